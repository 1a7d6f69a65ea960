#include "acus/imaging/ultrasound/display/auto_gain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace acus::ultrasound {

double AutoGainChangeDb(const image::GrayImage& image, double dynamic_range_db) {
  std::array<std::size_t, 256> count{};
  for (const std::uint8_t grey : image.pixels) ++count[grey];
  std::size_t bright = 0;
  for (std::size_t grey = kDarkGrey + 1; grey < count.size(); ++grey) bright += count[grey];
  if (50 * bright < image.pixels.size() || bright == 0) return kMostGainChangeDb;
  std::size_t grey = kDarkGrey;
  for (std::size_t below = 0; 2 * below < bright; below += count[grey]) ++grey;
  const double missing = kTissueGrey - static_cast<double>(grey);
  return std::clamp(std::round(missing * dynamic_range_db / 255.0), -kMostGainChangeDb,
                    kMostGainChangeDb);
}

}  // namespace acus::ultrasound
