#include "acus/assess/regression/comparison/image_difference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "acus/base/core/error.h"

namespace acus::comparison {
namespace {

constexpr double kSigma = 1.5;
constexpr std::size_t kWindow = 11;

/// Local sums from which SSIM is computed. It needs the two variances only as their sum.
enum Moment { kA, kB, kSquares, kProduct, kNumMoments };

void RequireSameSize(const GrayView& a, const GrayView& b) {
  ACUS_ASSERT(a.width == b.width && a.height == b.height && a.width > 0 && a.height > 0);
  const std::size_t count = static_cast<std::size_t>(a.width) * static_cast<std::size_t>(a.height);
  ACUS_ASSERT(a.pixels.size() == count && b.pixels.size() == count);
}

/// Weights of a Gaussian of `count` points, sum 1.
std::vector<double> Weights(std::size_t count) {
  std::vector<double> weights(count);
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = static_cast<double>(i) - 0.5 * static_cast<double>(count - 1);
    weights[i] = std::exp(-0.5 * x * x / (kSigma * kSigma));
    sum += weights[i];
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// out[i] = sum over k of weights[k] * in[k][i]: the inner loops. Four rows at once, so that the
/// sum stays in registers.
void WeightedSum(double* out, const std::vector<const double*>& in,
                 const std::vector<double>& weights, std::size_t count) {
  std::fill_n(out, count, 0.0);
  std::size_t k = 0;
  for (; k + 4 <= weights.size(); k += 4) {
    const double* const in0 = in[k];
    const double* const in1 = in[k + 1];
    const double* const in2 = in[k + 2];
    const double* const in3 = in[k + 3];
    for (std::size_t i = 0; i < count; ++i) {
      out[i] += (weights[k] * in0[i] + weights[k + 1] * in1[i]) +
                (weights[k + 2] * in2[i] + weights[k + 3] * in3[i]);
    }
  }
  for (; k < weights.size(); ++k) {
    for (std::size_t i = 0; i < count; ++i) out[i] += weights[k] * in[k][i];
  }
}

/// The moments of one row of pixels.
void RowMoments(const GrayView& a, const GrayView& b, std::size_t row,
                std::array<std::vector<double>, kNumMoments>& moments) {
  const auto width = static_cast<std::size_t>(a.width);
  for (std::size_t i = 0; i < width; ++i) {
    const double va = static_cast<double>(a.pixels[row * width + i]);
    const double vb = static_cast<double>(b.pixels[row * width + i]);
    moments[kA][i] = va;
    moments[kB][i] = vb;
    moments[kSquares][i] = va * va + vb * vb;
    moments[kProduct][i] = va * vb;
  }
}

double RowSsim(const std::array<std::vector<double>, kNumMoments>& local, std::size_t count) {
  constexpr double kC1 = (0.01 * 255.0) * (0.01 * 255.0);
  constexpr double kC2 = (0.03 * 255.0) * (0.03 * 255.0);
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double mean_a = local[kA][i];
    const double mean_b = local[kB][i];
    const double covariance = local[kProduct][i] - mean_a * mean_b;
    const double variances = local[kSquares][i] - mean_a * mean_a - mean_b * mean_b;
    sum += (2.0 * mean_a * mean_b + kC1) * (2.0 * covariance + kC2) /
           ((mean_a * mean_a + mean_b * mean_b + kC1) * (variances + kC2));
  }
  return sum;
}

}  // namespace

double MeanSquaredError(const GrayView& a, const GrayView& b) {
  RequireSameSize(a, b);
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const int difference = int{a.pixels[i]} - int{b.pixels[i]};
    sum += difference * difference;
  }
  return static_cast<double>(sum) / static_cast<double>(a.pixels.size());
}

std::optional<double> PsnrDb(double mean_squared_error) {
  if (mean_squared_error <= 0.0) return std::nullopt;
  return 10.0 * std::log10(255.0 * 255.0 / mean_squared_error);
}

double Ssim(const GrayView& a, const GrayView& b) {
  RequireSameSize(a, b);
  if (std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size()) == 0) return 1.0;
  const auto width = static_cast<std::size_t>(a.width);
  const auto height = static_cast<std::size_t>(a.height);
  const std::vector<double> across = Weights(std::min(kWindow, width));
  const std::vector<double> down = Weights(std::min(kWindow, height));
  const std::size_t out_width = width - across.size() + 1;
  const std::size_t out_height = height - down.size() + 1;

  std::array<std::vector<double>, kNumMoments> row;
  for (auto& values : row) values.resize(width);
  // Horizontally filtered rows of the last window: row r is at r % down.size().
  std::array<std::vector<double>, kNumMoments> ring;
  for (auto& values : ring) values.resize(out_width * down.size());
  std::array<std::vector<double>, kNumMoments> local;
  for (auto& values : local) values.resize(out_width);
  double sum = 0.0;
  for (std::size_t r = 0; r < height; ++r) {
    RowMoments(a, b, r, row);
    const std::size_t slot = r % down.size() * out_width;
    std::vector<const double*> from(across.size());
    for (int m = 0; m < kNumMoments; ++m) {
      for (std::size_t k = 0; k < across.size(); ++k) from[k] = row[m].data() + k;
      WeightedSum(ring[m].data() + slot, from, across, out_width);
    }
    if (r + 1 < down.size()) continue;
    const std::size_t first = r + 1 - down.size();
    from.resize(down.size());
    for (int m = 0; m < kNumMoments; ++m) {
      for (std::size_t k = 0; k < down.size(); ++k) {
        from[k] = ring[m].data() + (first + k) % down.size() * out_width;
      }
      WeightedSum(local[m].data(), from, down, out_width);
    }
    sum += RowSsim(local, out_width);
  }
  return sum / static_cast<double>(out_width * out_height);
}

}  // namespace acus::comparison
