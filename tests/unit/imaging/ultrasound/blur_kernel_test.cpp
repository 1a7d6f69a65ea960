#include "acus/imaging/ultrasound/speckle/blur_kernel.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "support/instruction_sets.h"

namespace acus::ultrasound::kernels {
namespace {

constexpr int kBlurLines = 37, kBlurSamples = 50, kBlurStride = 40;

std::vector<float> BlurPlane() {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> value(0.0F, 1.0F);
  std::vector<float> out(kBlurStride * kBlurSamples);
  for (float& v : out) v = value(random);
  return out;
}

BlurredPlane Of(const std::vector<float>& data) {
  return {data.data(), kBlurStride, kBlurLines, kBlurSamples};
}

double SlowMean(const std::vector<float>& data, double line, double sample, double lines_per_tap,
                double samples_per_tap, int taps) {
  double sum = 0.0;
  for (int t = -taps; t <= taps; ++t) {
    const double x = std::clamp(line + t * lines_per_tap, 0.0, kBlurLines - 1.0);
    const double y = std::clamp(sample + t * samples_per_tap, 0.0, kBlurSamples - 1.0);
    const int c = std::min(static_cast<int>(x), kBlurLines - 2);
    const int r = std::min(static_cast<int>(y), kBlurSamples - 2);
    const auto at = [&](int row, int column) {
      return static_cast<double>(data[static_cast<std::size_t>(row * kBlurStride + column)]);
    };
    sum += (1 - (y - r)) * ((1 - (x - c)) * at(r, c) + (x - c) * at(r, c + 1)) +
           (y - r) * ((1 - (x - c)) * at(r + 1, c) + (x - c) * at(r + 1, c + 1));
  }
  return sum / (2 * taps + 1);
}

TEST(BlurKernel, IsTheMeanAndTheSameWithEveryInstructionSet) {
  const std::vector<float> data = BlurPlane();
  std::mt19937 random(6);
  std::uniform_real_distribution<float> step(-1.0F, 1.0F);
  for (int n = 0; n < 300; ++n) {
    const auto line = static_cast<float>(n % kBlurLines);
    const auto sample = static_cast<float>(n % kBlurSamples);
    const float across = step(random), along = n % 7 == 0 ? 0.0F : step(random);
    const int taps = n % 40;
    const float first = MeanAlong(Of(data), line, sample, across, along, taps);
    EXPECT_NEAR(first, SlowMean(data, line, sample, across, along, taps), 2e-6);
    testing_support::OnEveryInstructionSet([&](const char* set) {
      EXPECT_EQ(MeanAlong(Of(data), line, sample, across, along, taps), first) << set;
    });
  }
}

TEST(BlurKernel, KeepsARampAndTheEdge) {
  std::vector<float> data(kBlurStride * kBlurSamples, -99.0F);
  for (int k = 0; k < kBlurSamples; ++k) {
    for (int l = 0; l < kBlurLines; ++l) {
      data[static_cast<std::size_t>(k * kBlurStride + l)] = static_cast<float>(3 * l - k);
    }
  }
  EXPECT_FLOAT_EQ(MeanAlong(Of(data), 18.0F, 25.0F, 0.7F, -0.6F, 12), 3 * 18 - 25);
  EXPECT_FLOAT_EQ(MeanAlong(Of(data), 36.0F, 49.0F, 0.0F, 0.0F, 5), 3 * 36 - 49);
  // To the right of the last line there is the last line: half of the taps.
  EXPECT_NEAR(MeanAlong(Of(data), 36.0F, 20.0F, 1.0F, 0.0F, 1), 3 * 36 - 20 - 1.0, 1e-5);
}

}  // namespace
}  // namespace acus::ultrasound::kernels
