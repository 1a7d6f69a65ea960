// The window of a live session: video with CT overlay, ultrasound, CT slice, images of effects, and
// the view in three dimensions for teaching.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/window/command.h"
#include "acus/window/frame.h"
#include "acus/window/layout.h"
#include "acus/window/stereo.h"
#include "acus/window/volume_renderer.h"
#include "acus/window/x_display.h"

namespace acus::window {

struct WindowSettings {
  std::string title = "Acus";
  int width_px = 1280;
  int height_px = 800;
  /// Surfaces of the teaching view are thinned out to this many triangles in all.
  int max_triangles = 40000;
  /// The overlay's image: of this many times the pixels of the video each way. Smaller is faster.
  double overlay_scale = 0.5;
  /// Opacity reaches its full value so far inside the patient's outline, in shares of the video's
  /// width.
  double edge_falloff_share = 0.10;
  /// The overlay is rendered beside Show(); while it is under way the last one is moved along with
  /// the patient. False: Show() waits for it.
  bool overlay_in_background = true;
  /// Those that may be shown, if there is something to show in them; empty: all but the volume
  /// view, which a key brings.
  std::vector<ViewKind> views;
  /// As VolumeViewSettings::moving_scale.
  double volume_moving_scale = 0.5;
  /// What casts its rays. kGraphics is refused where there is no driver.
  VolumeRays volume_rays = VolumeRays::kAuto;
  /// The volume view is rendered beside Show(). False: Show() waits for it.
  bool volume_in_background = true;
  /// The teaching view is drawn anew in each n-th Show().
  int teaching_view_each = 1;
};

/// A window. All calls from the thread that made it.
class Window {
 public:
  /// Opens it.
  /// @throws InputError if there is no display, or a setting or surface is not usable.
  Window(const PatientOnDisplay& patient, const WindowSettings& settings);
  ~Window();
  Window(Window&&) noexcept;
  Window& operator=(Window&&) noexcept;

  /// Handles what the person did, then shows a moment. A value that is not finite is not drawn.
  void Show(const DisplayFrame& frame);
  /// Handles what the person did.
  void HandleEvents();
  /// Handles what the person did, then shows a sentence over the last moment, without its readouts.
  void ShowText(const std::string& text);
  /// Keys, views and eye as at first; what the person did and nobody took is forgotten.
  void Restart();

  /// Since the last call, oldest first.
  std::vector<Command> TakeCommands();
  HandInput TakeHandInput();

  bool closed() const;    ///< By the person: Show() does nothing any more.
  Layout layout() const;  ///< Where the views are now.

  /// What is on the screen now.
  image::ColourImage Screenshot(EyeSide eye = EyeSide::kLeft);
  /// Number of volume renderings made for the overlay so far.
  long num_overlays() const;
  /// Of the volume view; nothing while it is not shown.
  std::optional<VolumeReadout> volume() const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace acus::window
