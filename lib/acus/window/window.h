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
#include "acus/window/screen.h"
#include "acus/window/stereo.h"
#include "acus/window/volume_renderer.h"
#include "acus/window/x_display.h"

namespace acus::window {

struct WindowSettings {
  std::string title = "Acus";
  int width_px = 1280;
  int height_px = 800;
  /// Surfaces of the teaching view are thinned to this total number of triangles.
  int max_triangles = 40000;
  /// Ratio of the overlay's width and height to the video's, in pixels. Smaller is faster.
  double overlay_scale = 0.5;
  /// Distance inside the patient's outline at which opacity reaches its full value, in shares of
  /// the video's width.
  double edge_falloff_share = 0.10;
  /// The overlay is rendered in parallel with Show(); while it is being rendered the last one moves
  /// with the patient. False: Show() waits for it.
  bool overlay_in_background = true;
  /// Views that may be shown, if they have content; empty: all except the volume view, which a key
  /// adds.
  std::vector<ViewKind> views;
  /// As VolumeViewSettings::moving_scale.
  double volume_moving_scale = 0.5;
  /// The device that casts its rays. kGraphics is an error if there is no driver.
  VolumeRays volume_rays = VolumeRays::kAuto;
  /// The volume view is rendered in parallel with Show(). False: Show() waits for it.
  bool volume_in_background = true;
  /// The teaching view is rendered in each n-th Show().
  int teaching_view_each = 1;
};

/// A window. All calls come from the constructing thread.
class Window {
 public:
  /// Opens the window.
  /// @param screen  Of a LoadingScreen that showed the preparation; null: a new one.
  /// @throws InputError if there is no display, or a setting or surface is not usable.
  Window(const PatientOnDisplay& patient, const WindowSettings& settings,
         std::unique_ptr<Screen> screen = nullptr);
  ~Window();
  Window(Window&&) noexcept;
  Window& operator=(Window&&) noexcept;

  /// Handles the user's input, then shows a frame. A value that is not finite is not drawn.
  void Show(const DisplayFrame& frame);
  /// Handles the user's input.
  void HandleEvents();
  /// Handles the user's input, then shows a sentence over the last frame, without its readouts.
  void ShowText(const std::string& text);
  /// Resets keys, views and eye; input that has not been taken is discarded.
  void Restart();

  /// The commands since the last call, oldest first.
  std::vector<Command> TakeCommands();
  HandInput TakeHandInput();

  bool closed() const;    ///< By the user: Show() does nothing any more.
  Layout layout() const;  ///< Current positions of the views.

  /// The current content of the screen.
  image::ColourImage Screenshot(EyeSide eye = EyeSide::kLeft);
  /// Number of volume renderings for the overlay so far.
  long num_overlays() const;
  /// State of the volume view; nothing while it is not shown.
  std::optional<VolumeReadout> volume() const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace acus::window
