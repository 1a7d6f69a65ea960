#include "acus/imaging/ultrasound/display/frame_persistence.h"

#include <cmath>

#include "acus/base/core/error.h"

namespace acus::ultrasound {

FramePersistence::FramePersistence(double time_constant_s) : time_constant_s_(time_constant_s) {
  ACUS_REQUIRE(time_constant_s >= 0.0 && std::isfinite(time_constant_s), "display: persistence of ",
               time_constant_s, " s; it may not be negative");
}

void FramePersistence::Add(std::int64_t time_ns, const image::GrayImage& frame,
                           image::GrayImage& out) {
  const bool goes_on = !mean_.empty() && frame.width == width_ && frame.height == height_ &&
                       time_ns >= last_ns_ && on();
  if (!goes_on) {
    width_ = frame.width;
    height_ = frame.height;
    mean_.assign(frame.pixels.begin(), frame.pixels.end());
  } else {
    const double dt_s = 1e-9 * static_cast<double>(time_ns - last_ns_);
    const auto share = static_cast<float>(-std::expm1(-dt_s / time_constant_s_));
    const std::uint8_t* in = frame.pixels.data();
    float* mean = mean_.data();
    for (std::size_t n = 0; n < mean_.size(); ++n) {
      mean[n] += share * (static_cast<float>(in[n]) - mean[n]);
    }
  }
  last_ns_ = time_ns;
  out.Resize(frame.width, frame.height);
  std::uint8_t* pixels = out.pixels.data();
  for (std::size_t n = 0; n < mean_.size(); ++n) {
    pixels[n] = static_cast<std::uint8_t>(static_cast<int>(mean_[n] + 0.5F));
  }
}

}  // namespace acus::ultrasound
