#include "acus/rig/camera/edge_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace acus::camera {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

enum Parameter { kOffset, kSlope, kMean, kGradient, kHalf, kSigma };

constexpr double kLeastContrast = 8.0;
constexpr double kLeastBlurPx = 0.15;
constexpr int kLeastPixels = 12;
constexpr double kLeastNoise = 0.5;   ///< Grey levels: that of rounding, generously.
constexpr double kFewOutliers = 0.8;  ///< Share of the weights; normal noise leaves 0.87.
constexpr double kWary = 0.1;         ///< Scale of residuals, of the contrast.
constexpr double kTukey = 4.685;      ///< 95 % efficient with normal noise.

struct Sample {
  double residual;
  Vector6 derivative;
};

Sample Evaluate(const EdgePixel& pixel, const Vector6& p) {
  const double sigma = p[kSigma];
  const double u =
      (pixel.across_px - p[kOffset] - p[kSlope] * pixel.along_px) / (std::numbers::sqrt2 * sigma);
  const double step = std::erf(u);
  const double bell = p[kHalf] * 2.0 * std::numbers::inv_sqrtpi * std::exp(-u * u);
  Sample sample;
  sample.residual = p[kMean] + p[kGradient] * pixel.along_px + p[kHalf] * step - pixel.level;
  const double by_across = bell / (std::numbers::sqrt2 * sigma);
  sample.derivative << -by_across, -by_across * pixel.along_px, 1.0, pixel.along_px, step,
      -bell * u / sigma;
  return sample;
}

Vector6 FirstGuess(std::span<const EdgePixel> pixels, double reach_px) {
  double dark = 0.0, light = 0.0;
  int dark_count = 0, light_count = 0;
  for (const EdgePixel& pixel : pixels) {
    if (pixel.across_px < -0.5 * reach_px) {
      dark += pixel.level;
      ++dark_count;
    } else if (pixel.across_px > 0.5 * reach_px) {
      light += pixel.level;
      ++light_count;
    }
  }
  dark /= std::max(1, dark_count);
  light /= std::max(1, light_count);
  Vector6 p;
  p << 0.0, 0.0, 0.5 * (light + dark), 0.0, 0.5 * (light - dark), std::max(0.6, 0.3 * reach_px);
  return p;
}

/// Robust scale of the residuals, grey levels.
double Scale(std::span<const EdgePixel> pixels, const Vector6& p, std::vector<double>& scratch) {
  scratch.clear();
  for (const EdgePixel& pixel : pixels) scratch.push_back(std::abs(Evaluate(pixel, p).residual));
  const auto middle = scratch.begin() + static_cast<std::ptrdiff_t>(scratch.size() / 2);
  std::nth_element(scratch.begin(), middle, scratch.end());
  return std::max(kLeastNoise, 1.4826 * *middle);
}

struct Normal {
  Matrix6 matrix = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  double weight = 0.0;
  double squares = 0.0;  ///< Weighted, of the residuals.
  double cost = 0.0;     ///< Tukey's.
};

Normal Accumulate(std::span<const EdgePixel> pixels, const Vector6& p, double scale) {
  const double cut = kTukey * scale;
  Normal normal;
  for (const EdgePixel& pixel : pixels) {
    const Sample sample = Evaluate(pixel, p);
    const double u = sample.residual / cut;
    if (std::abs(u) >= 1.0) {
      normal.cost += cut * cut / 6.0;
      continue;
    }
    const double root = 1.0 - u * u;
    const double weight = root * root;
    normal.matrix.selfadjointView<Eigen::Lower>().rankUpdate(sample.derivative, weight);
    normal.right -= weight * sample.residual * sample.derivative;
    normal.weight += weight;
    normal.squares += weight * sample.residual * sample.residual;
    normal.cost += cut * cut / 6.0 * (1.0 - weight * root);
  }
  normal.matrix = normal.matrix.selfadjointView<Eigen::Lower>();
  return normal;
}

/// Levenberg-Marquardt with one scale of the residuals.
Normal Descend(std::span<const EdgePixel> pixels, double scale, double reach_px, Vector6& p) {
  Normal normal = Accumulate(pixels, p, scale);
  double damping = 1e-3;
  for (int iteration = 0; iteration < 15 && damping < 1e6; ++iteration) {
    Matrix6 damped = normal.matrix;
    damped.diagonal() *= 1.0 + damping;
    damped.diagonal().array() += 1e-9;
    Vector6 moved = p + damped.ldlt().solve(normal.right);
    moved[kSigma] = std::clamp(moved[kSigma], kLeastBlurPx, 2.0 * reach_px);
    if (!moved.allFinite()) break;
    const Normal there = Accumulate(pixels, moved, scale);
    if (there.cost > normal.cost) {
      damping *= 10.0;
      continue;
    }
    const Vector6 step = moved - p;
    p = moved;
    normal = there;
    damping = std::max(1e-6, 0.1 * damping);
    if (std::abs(step[kOffset]) < 1e-4 && std::abs(step[kSlope]) < 1e-5) break;
  }
  return normal;
}

bool IsEdge(const Vector6& p, double reach_px) {
  return p.allFinite() && std::abs(p[kOffset]) < reach_px && std::abs(p[kSlope]) < 0.5 &&
         2.0 * p[kHalf] > kLeastContrast;
}

}  // namespace

std::optional<EdgeFit> FitEdge(std::span<const EdgePixel> pixels, double reach_px) {
  if (pixels.size() < kLeastPixels) return std::nullopt;
  Vector6 p = FirstGuess(pixels, reach_px);
  std::vector<double> scratch;
  const Vector6 guess = p;
  // First with nothing omitted, then without what sticks out, by its new scale.
  Normal normal = Descend(pixels, /*scale=*/255.0, reach_px, p);
  for (int round = 0; round < 2; ++round) {
    normal = Descend(pixels, Scale(pixels, p, scratch), reach_px, p);
  }
  if (normal.weight < kFewOutliers * static_cast<double>(pixels.size())) {
    // Something may lie over the edge and have drawn the first fit away: begin with little trust.
    Vector6 other = guess;
    Descend(pixels, kWary * std::max(kLeastContrast, 2.0 * guess[kHalf]), reach_px, other);
    const double scale = std::min(Scale(pixels, p, scratch), Scale(pixels, other, scratch));
    const Normal there = Descend(pixels, scale, reach_px, other);
    if (IsEdge(other, reach_px) && there.cost < Accumulate(pixels, p, scale).cost) {
      p = other;
      normal = there;
    }
  }
  if (normal.weight < kLeastPixels) return std::nullopt;
  if (!IsEdge(p, reach_px)) return std::nullopt;
  const double variance = std::max(kLeastNoise * kLeastNoise * 0.1,
                                   normal.squares / std::max(1.0, normal.weight - 6.0));
  Matrix6 information = normal.matrix;
  information.diagonal().array() += 1e-9;
  const Matrix6 covariance = information.ldlt().solve(Matrix6::Identity()) * variance;
  EdgeFit fit{.offset_px = p[kOffset],
              .slope = p[kSlope],
              .covariance = covariance.topLeftCorner<2, 2>(),
              .blur_sigma_px = p[kSigma],
              .contrast = 2.0 * p[kHalf]};
  if (!fit.covariance.allFinite()) return std::nullopt;
  return fit;
}

}  // namespace acus::camera
