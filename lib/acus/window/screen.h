// The window of the operating system, and the user's input in it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/window/stereo.h"

class vtkRenderer;

namespace acus::window {

/// An input by the user. Positions are pixels from the upper left corner.
struct InputEvent {
  enum class Kind {
    kKeyDown,
    kKeyUp,
    kMove,
    kButtonDown,
    kButtonUp,
    kWheelForward,
    kWheelBackward,
    kClose
  };
  Kind kind = Kind::kMove;
  std::string key;  ///< X's name: "f", "G", "Tab", "space"; letters with Shift are capitals.
  int button = 0;   ///< 1 left, 2 middle, 3 right.
  int column = 0;
  int row = 0;
  bool shift = false;
};

/// Renderers are drawn in the order of their layers. All calls come from the constructing thread.
class Screen {
 public:
  static constexpr int kNumLayers = 3;

  /// @throws InputError if there is no display.
  Screen(const std::string& title, int width_px, int height_px);
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  void Add(vtkRenderer* renderer, int layer);
  void Remove(vtkRenderer* renderer);
  /// The events since the last call.
  std::vector<InputEvent> TakeEvents();
  /// False: no key is held any more, whether or not its release was reported.
  bool HasHeldKeys() const;
  /// Draws all layers and shows them.
  void Render();
  /// Whether the graphics driver has given the window buffers for both eyes.
  bool has_shutter() const;
  /// Applies to the whole window. kShutter without has_shutter(), and kSideBySide, show one eye.
  void SetStereo(Stereo stereo);

  int width_px() const;
  int height_px() const;
  /// The right eye has a separate image with SetStereo(kShutter) only.
  image::ColourImage Screenshot(EyeSide eye = EyeSide::kLeft);

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace acus::window
