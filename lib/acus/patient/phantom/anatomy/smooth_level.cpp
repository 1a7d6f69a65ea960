#include "acus/patient/phantom/anatomy/smooth_level.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/parallel.h"
#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::phantom {
namespace {

volume::Grid<float> SignedDistance(const volume::Grid<std::uint8_t>& inside, int num_threads) {
  segmentation::Mask outside(inside.geometry);
  std::ranges::transform(inside.voxels, outside.voxels.begin(),
                         [](std::uint8_t value) { return value == 0 ? 1 : 0; });
  volume::Grid<float> to_inside = segmentation::DistanceMm(inside, num_threads);
  const volume::Grid<float> to_outside = segmentation::DistanceMm(outside, num_threads);
  // The surface lies half way between the centres of neighbours.
  const auto half = static_cast<float>(0.5 * inside.geometry.spacing_mm.minCoeff());
  for (std::size_t n = 0; n < to_inside.voxels.size(); ++n) {
    to_inside.voxels[n] =
        inside.voxels[n] != 0 ? half - to_outside.voxels[n] : to_inside.voxels[n] - half;
  }
  return to_inside;
}

/// Gaussian along one axis; beyond the border as at it.
void Smooth(volume::Grid<float>& grid, int axis, double sigma_mm, int num_threads) {
  const volume::Geometry& g = grid.geometry;
  const double sigma = sigma_mm / g.spacing_mm[axis];
  const int reach = static_cast<int>(std::ceil(3.0 * sigma));
  std::vector<double> kernel;
  double sum = 0.0;
  for (int n = -reach; n <= reach; ++n) {
    kernel.push_back(std::exp(-0.5 * n * n / (sigma * sigma)));
    sum += kernel.back();
  }
  for (double& value : kernel) value /= sum;
  const int other = axis == 2 ? 1 : 2;
  const int third = 3 - axis - other;
  ParallelFor(g.size[other], num_threads, [&](int b) {
    std::vector<float> line(static_cast<std::size_t>(g.size[axis]));
    for (int a = 0; a < g.size[third]; ++a) {
      Eigen::Array3i voxel;
      voxel[other] = b;
      voxel[third] = a;
      const auto at = [&](int n) -> float& {
        voxel[axis] = n;
        return grid.At(voxel[0], voxel[1], voxel[2]);
      };
      for (int n = 0; n < g.size[axis]; ++n) line[static_cast<std::size_t>(n)] = at(n);
      for (int n = 0; n < g.size[axis]; ++n) {
        double value = 0.0;
        for (int m = -reach; m <= reach; ++m) {
          const int from = std::clamp(n + m, 0, g.size[axis] - 1);
          value += kernel[static_cast<std::size_t>(m + reach)] *
                   static_cast<double>(line[static_cast<std::size_t>(from)]);
        }
        at(n) = static_cast<float>(value);
      }
    }
  });
}

/// The four weights of a uniform cubic B-spline at t in [0, 1], and their derivatives.
struct SplineWeights {
  explicit SplineWeights(double t) {
    const double s = 1.0 - t;
    value = {s * s * s / 6.0, (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
             (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0, t * t * t / 6.0};
    slope = {-0.5 * s * s, 1.5 * t * t - 2.0 * t, -1.5 * s * s + 2.0 * s, 0.5 * t * t};
  }
  std::array<double, 4> value, slope;
};

}  // namespace

SmoothLevel::SmoothLevel(const volume::Grid<std::uint8_t>& inside, double sigma_mm,
                         double offset_mm, int num_threads) {
  const volume::Geometry& g = inside.geometry;
  ACUS_REQUIRE(
      g.direction.isIdentity(1e-9) && (g.size >= 4).all(),
      "smooth surface: a grid along the axes of CT space with at least 4 voxels along each "
      "is needed");
  const std::size_t count = segmentation::Count(inside);
  ACUS_REQUIRE(count > 0 && count < g.num_voxels(),
               "smooth surface: ", count == 0 ? "nothing" : "everything", " is inside it");
  coefficients_ = SignedDistance(inside, num_threads);
  for (int axis = 0; axis < 3; ++axis) Smooth(coefficients_, axis, sigma_mm, num_threads);
  for (float& value : coefficients_.voxels) value += static_cast<float>(offset_mm);
}

SmoothLevel::Sample SmoothLevel::At(const Eigen::Vector3d& point_ct_mm) const noexcept {
  const volume::Geometry& g = coefficients_.geometry;
  const Eigen::Array3d index = ((point_ct_mm - g.origin_mm).array() / g.spacing_mm)
                                   .max(0.0)
                                   .min((g.size - 1).cast<double>());
  const Eigen::Array3i base = index.cast<int>().min(g.size - 2);
  const std::array<SplineWeights, 3> w = {SplineWeights(index[0] - base[0]),
                                          SplineWeights(index[1] - base[1]),
                                          SplineWeights(index[2] - base[2])};
  const auto from = [&](int axis, std::size_t n) {
    return std::clamp(base[axis] + static_cast<int>(n) - 1, 0, g.size[axis] - 1);
  };
  const std::array<int, 4> i = {from(0, 0), from(0, 1), from(0, 2), from(0, 3)};
  Sample out;
  for (std::size_t c = 0; c < 4; ++c) {
    double value = 0.0, slope_x = 0.0, slope_y = 0.0;  // Of the plane c.
    for (std::size_t b = 0; b < 4; ++b) {
      const float* row = &coefficients_.voxels[g.Index(0, from(1, b), from(2, c))];
      double along = 0.0, slope = 0.0;
      for (std::size_t a = 0; a < 4; ++a) {
        const double sample = static_cast<double>(row[i[a]]);
        along += w[0].value[a] * sample;
        slope += w[0].slope[a] * sample;
      }
      value += w[1].value[b] * along;
      slope_x += w[1].value[b] * slope;
      slope_y += w[1].slope[b] * along;
    }
    out.level_mm += w[2].value[c] * value;
    out.gradient.x() += w[2].value[c] * slope_x;
    out.gradient.y() += w[2].value[c] * slope_y;
    out.gradient.z() += w[2].slope[c] * value;
  }
  out.gradient.array() /= g.spacing_mm;
  return out;
}

}  // namespace acus::phantom
