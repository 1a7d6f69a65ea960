#include "acus/imaging/ultrasound/speckle/clutter_haze.h"

#include <algorithm>
#include <cmath>

#include "acus/imaging/ultrasound/aperture/aperture_kernels.h"

namespace acus::ultrasound {

ClutterHaze::ClutterHaze(int lines, int lanes, double row_mm, double reach_mm, double haze_db)
    : lines_(lines),
      lanes_(lanes),
      keep_(static_cast<float>(std::exp(-row_mm / reach_mm))),
      share_(static_cast<float>(std::pow(std::pow(10.0, haze_db / 20.0), 2.0))),
      haze_(static_cast<std::size_t>(lanes), 0.0F),
      sums_(static_cast<std::size_t>(lanes) + 1, 0.0F) {}

void ClutterHaze::Begin() {
  std::fill(haze_.begin(), haze_.end(), 0.0F);
}

void ClutterHaze::AddRow(const float* bright, float* speckle) {
  float sum = 0.0F;
  for (int l = 0; l < lanes_; ++l) {
    sum += speckle[l] + (1.0F / 64) * bright[l];
    sums_[static_cast<std::size_t>(l) + 1] = sum;
  }
  Blur();
  kernels::AddRootRow(haze_.data(), share_, lanes_, speckle);
}

void ClutterHaze::Blur() {
  const int reach = std::max(1, lines_ / 12);
  const auto blend = [&](int l, int low, int high) {
    const float mean =
        (sums_[static_cast<std::size_t>(high) + 1] - sums_[static_cast<std::size_t>(low)]) /
        static_cast<float>(high - low + 1);
    float& at = haze_[static_cast<std::size_t>(l)];
    at = keep_ * at + (1.0F - keep_) * mean;
  };
  const int inner = std::min(reach, lanes_);
  const int outer = std::max(inner, lanes_ - reach);
  for (int l = 0; l < inner; ++l) blend(l, 0, std::min(lanes_ - 1, l + reach));
  const float weight = (1.0F - keep_) / static_cast<float>(2 * reach + 1);
  for (int l = inner; l < outer; ++l) {
    const float sum =
        sums_[static_cast<std::size_t>(l + reach) + 1] - sums_[static_cast<std::size_t>(l - reach)];
    haze_[static_cast<std::size_t>(l)] = keep_ * haze_[static_cast<std::size_t>(l)] + weight * sum;
  }
  for (int l = outer; l < lanes_; ++l) blend(l, std::max(0, l - reach), lanes_ - 1);
}

}  // namespace acus::ultrasound
