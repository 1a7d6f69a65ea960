// Spatial compounding: images of several steering angles, averaged on the screen.
#pragma once

#include <cstdint>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/ultrasound/display/beam_display.h"

namespace acus::ultrasound {

/// Pixel by pixel the mean grey of all images that cover it, within the image that is not steered.
/// Greys are logarithms: n images of independent speckle leave its standard deviation of
/// 10 / ln(10) pi / sqrt(6) = 5.57 dB divided by sqrt(n).
class CompoundImage {
 public:
  /// @param looks  One display for each angle, the first not steered. They must outlive this.
  explicit CompoundImage(std::vector<BeamDisplay*> looks);

  /// All rows of all displays must be compressed. The same bits with any `num_threads`.
  void Show(image::GrayImage& out, int num_threads);

 private:
  void ShowRow(int r, image::GrayImage& out);

  std::vector<BeamDisplay*> looks_;
  std::vector<std::uint8_t> count_;  ///< Images that cover a pixel.
  std::vector<std::uint16_t> sum_;   ///< By pixel.
  image::GrayImage look_;
};

}  // namespace acus::ultrasound
