#include "acus/patient/atlas/hu_density.h"

#include <algorithm>
#include <cmath>

namespace acus::atlas {

std::size_t HuDensity::Bin(double hu) {
  return static_cast<std::size_t>(
      std::clamp(static_cast<int>(std::lround(hu)) - kLowest, 0, kBins - 1));
}

void HuDensity::Normalise() {
  std::vector<double> blurred(kBins, 0.0);
  double sum = 0.0;
  for (int b = 0; b < kBins; ++b) {
    double& value = blurred[static_cast<std::size_t>(b)];
    const int last = std::min(kBins - 1, b + 3 * blur_hu_);
    for (int c = std::max(0, b - 3 * blur_hu_); c <= last; ++c) {
      const double z = static_cast<double>(b - c) / blur_hu_;
      value += count_[static_cast<std::size_t>(c)] * std::exp(-0.5 * z * z);
    }
    sum += value;
  }
  if (sum > 0.0) {
    for (double& value : blurred) value /= sum;
  }
  count_ = std::move(blurred);
}

int HuDensity::Peak() const {
  return static_cast<int>(std::ranges::max_element(count_) - count_.begin()) + kLowest;
}

}  // namespace acus::atlas
