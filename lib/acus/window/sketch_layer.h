// Draws a sketch over a window.
#pragma once

#include <memory>

#include "acus/window/sketch.h"

class vtkRenderer;

namespace acus::window {

class SketchLayer {
 public:
  /// @param atlas  The atlas of the sketches.
  explicit SketchLayer(const FontAtlas& atlas);
  ~SketchLayer();
  SketchLayer(const SketchLayer&) = delete;
  SketchLayer& operator=(const SketchLayer&) = delete;

  vtkRenderer* renderer();
  void Draw(const Sketch& sketch, int window_height_px);

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace acus::window
