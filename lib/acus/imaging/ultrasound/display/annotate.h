// Images for people: depth scale, marks, text, B-mode and CT slice side by side.
#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"

namespace acus::ultrasound {

/// Writes text into an image, its upper left corner at (column, row). What is not inside the
/// image is omitted. Letters are about 10 pixels high times `scale`.
void DrawText(image::GrayImage& image, int column, int row, std::string_view text,
              std::uint8_t grey = 230, double scale = 1.0);

/// Lays out the image that videos show. Marks are drawn once, so that a frame costs two copies.
class Screen {
 public:
  enum class Shows { kBMode, kCtSlice, kBoth };

  /// The B-mode is on the left of the two; they have the same scale. Depth ticks each 5 mm (10 mm
  /// for depths above 100 mm), labelled each second one in cm; a ring at the top on the marked
  /// side; below the probe's name and depth. With a B-mode also a triangle beside the ticks at the
  /// focus, and frequency, gain and dynamic range.
  Screen(const acoustics::Probe& probe, Shows shows);

  /// @param left  The B-mode, or the CT slice alone.
  /// @param ct_slice  Beside a B-mode: must be given if and only if the screen shows both.
  /// @param text  One line at the top left, such as the time and the force.
  /// @throws InputError if an image has another size than the probe's.
  void Compose(const image::GrayImage& left, const image::GrayImage* ct_slice,
               std::string_view text, image::GrayImage& out) const;

  int width_px() const { return panels() * image_.width_px; }
  int height_px() const { return image_.height_px; }

 private:
  void DrawMarks(const acoustics::Probe& probe);
  int panels() const { return shows_ == Shows::kBoth ? 2 : 1; }

  image::ImageGeometry image_;
  Shows shows_;
  std::vector<std::pair<std::size_t, std::uint8_t>> marks_;  ///< Pixel of the screen, grey.
};

}  // namespace acus::ultrasound
