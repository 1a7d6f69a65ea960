// Pictures for people: depth scale, marks, text, B-mode and CT slice side by side.
#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include "ultrasound/image.h"
#include "ultrasound/probe.h"

namespace acus::ultrasound {

/// Writes text into a picture, its upper left corner at (column, row). What is not inside the
/// picture is left out. Letters are about 10 pixels high times `scale`.
void DrawText(GrayImage& picture, int column, int row, std::string_view text,
              std::uint8_t grey = 230, double scale = 1.0);

/// Lays out the picture that films show. Marks are drawn once, so that a frame costs two copies.
class Screen {
 public:
  /// One panel for the B-mode, and one on its right for the CT slice if `with_ct_slice`. Both have
  /// the same scale. Depth ticks each 5 mm (10 mm for depths above 100 mm), labelled each second
  /// one in cm; a triangle beside them at the focus; a ring at the top on the marked side; below
  /// the probe's name, frequency, depth, gain and dynamic range.
  Screen(const Probe& probe, bool with_ct_slice);

  /// @param ct_slice  Must be given if and only if the screen has a panel for it.
  /// @param text  One line at the top left, such as the time and the force.
  /// @throws InputError if a picture has another size than the probe's.
  void Compose(const GrayImage& bmode, const GrayImage* ct_slice, std::string_view text,
               GrayImage& out) const;

  int width_px() const { return panels_ * picture_.width_px; }
  int height_px() const { return picture_.height_px; }

 private:
  void DrawMarks(const Probe& probe);

  ImageGeometry picture_;
  int panels_;
  std::vector<std::pair<std::size_t, std::uint8_t>> marks_;  ///< Pixel of the screen, grey.
};

}  // namespace acus::ultrasound
