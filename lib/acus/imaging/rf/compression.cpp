#include "acus/imaging/rf/compression.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::rf {

image::GrayImage Compressed(const IqImage& image, double dynamic_range_db) {
  ACUS_REQUIRE(dynamic_range_db > 0.0, "compression: the dynamic range is ", dynamic_range_db,
               " dB; it must be above 0");
  const std::vector<float> envelope = Envelope(image);
  image::GrayImage out;
  out.Resize(image.grid.columns, image.grid.rows);
  const float brightest = envelope.empty() ? 0.0F : *std::ranges::max_element(envelope);
  for (std::size_t i = 0; i < envelope.size(); ++i) {
    const double below_db =
        brightest > 0.0F ? 20.0 * std::log10(std::max(1e-12F, envelope[i] / brightest)) : -1e3;
    const double grey = 255.0 * (1.0 + below_db / dynamic_range_db);
    out.pixels[i] = static_cast<std::uint8_t>(std::clamp(std::lround(grey), 0L, 255L));
  }
  return out;
}

}  // namespace acus::rf
