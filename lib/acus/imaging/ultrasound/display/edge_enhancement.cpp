#include "acus/imaging/ultrasound/display/edge_enhancement.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::ultrasound {
namespace {

constexpr int kMaxHalf = 64;
constexpr int kUnit = 1 << 14;
constexpr int kBatch = 256;

}  // namespace

EdgeEnhancement::EdgeEnhancement(double strength, double sigma_mm, double step_mm) {
  ACUS_REQUIRE(strength >= 0.0 && strength <= 4.0 && sigma_mm >= 0.0 && std::isfinite(sigma_mm) &&
                   step_mm > 0.0,
               "display: edge strength ", strength, " over ", sigma_mm,
               " mm; allowed is a strength of 0 to 4 over 0 mm or more");
  if (strength == 0.0 || sigma_mm == 0.0) return;
  const double sigma = sigma_mm / step_mm;
  const int half = static_cast<int>(std::ceil(3.0 * sigma));
  ACUS_REQUIRE(half <= kMaxHalf, "display: edges of ", sigma_mm, " mm cover ", 2 * half + 1,
               " rows of ", step_mm,
               " mm; give a smaller edge_sigma_mm, or fewer samples_per_line");
  std::vector<double> window;
  double sum = 0.0;
  for (int t = 0; t <= half; ++t) {
    window.push_back(std::exp(-0.5 * t * t / (sigma * sigma)));
    sum += t == 0 ? window.back() : 2.0 * window.back();
  }
  int whole = 0;
  for (int t = 0; t <= half; ++t) {
    weight_.push_back(static_cast<int>(
        std::lround(strength * kUnit * window[static_cast<std::size_t>(t)] / sum)));
    whole += t == 0 ? weight_.back() : 2 * weight_.back();
  }
  // Even areas stay as they are, to the bit.
  gain_ = kUnit + whole;
}

void EdgeEnhancement::EnhanceRow(const std::uint8_t* grey, std::ptrdiff_t stride, int rows, int k,
                                 int lanes, std::uint8_t* out) const {
  const auto row = [&](int n) { return grey + std::clamp(n, 0, rows - 1) * stride; };
  std::array<int, kBatch> sum;
  for (int first = 0; first < lanes; first += kBatch) {
    const int count = std::min(kBatch, lanes - first);
    const std::uint8_t* here = row(k) + first;
    const int middle = gain_ - weight_[0];
    for (int l = 0; l < count; ++l) sum[static_cast<std::size_t>(l)] = middle * here[l];
    for (std::size_t t = 1; t < weight_.size(); ++t) {
      const std::uint8_t* above = row(k - static_cast<int>(t)) + first;
      const std::uint8_t* below = row(k + static_cast<int>(t)) + first;
      const int weight = weight_[t];
      for (int l = 0; l < count; ++l) {
        sum[static_cast<std::size_t>(l)] -= weight * (above[l] + below[l]);
      }
    }
    for (int l = 0; l < count; ++l) {
      const int value = (sum[static_cast<std::size_t>(l)] + kUnit / 2) >> 14;
      out[first + l] = static_cast<std::uint8_t>(std::clamp(value, 0, 255));
    }
  }
}

}  // namespace acus::ultrasound
