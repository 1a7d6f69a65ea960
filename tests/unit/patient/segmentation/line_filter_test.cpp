#include "acus/patient/segmentation/voxels/line_filter.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/base/core/random.h"

namespace acus::segmentation {
namespace {

using Eigen::Vector3d;

volume::Geometry GridOf(const Eigen::Array3d& spacing_mm, double side_mm) {
  volume::Geometry g;
  g.spacing_mm = spacing_mm;
  g.size = (side_mm / spacing_mm).ceil().cast<int>();
  return g;
}

/// Mean over each voxel of a function that is 1 inside a shape and 0 outside.
template <typename Inside>
volume::Grid<float> PartsInside(const volume::Geometry& g, const Inside& inside) {
  constexpr int kSamples = 5;
  volume::Grid<float> out(g);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        int count = 0;
        for (int n = 0; n < kSamples * kSamples * kSamples; ++n) {
          const Vector3d in_voxel(n % kSamples, n / kSamples % kSamples, n / (kSamples * kSamples));
          const Vector3d index =
              Vector3d(i, j, k) + ((in_voxel.array() + 0.5) / kSamples - 0.5).matrix();
          count += inside(g.ct_from_index() * index) ? 1 : 0;
        }
        out.At(i, j, k) = static_cast<float>(count) / (kSamples * kSamples * kSamples);
      }
    }
  }
  return out;
}

float Middle(const volume::Grid<float>& grid) {
  const Eigen::Array3i& size = grid.geometry.size;
  return grid.At(size[0] / 2, size[1] / 2, size[2] / 2);
}

Vector3d CentreOf(const volume::Geometry& g) {
  return g.ct_from_index() * (g.size / 2).cast<double>().matrix();
}

TEST(LineResponse, OfACylinderIsThatOfTheClosedForm) {
  constexpr float kContrastHu = 50.0F;
  constexpr double kRadiusMm = 4.0;
  for (const Vector3d& axis : {Vector3d(0, 0, 1), Vector3d(1, 0, 0), Vector3d(1, 2, -1.5)}) {
    volume::Geometry g = GridOf({0.8, 0.8, 1.0}, 40.0);
    const Vector3d centre = CentreOf(g), along = axis.normalized();
    volume::Grid<float> image = PartsInside(g, [&](const Vector3d& p) {
      return (p - centre - along * along.dot(p - centre)).norm() < kRadiusMm;
    });
    for (float& value : image.voxels) value *= kContrastHu;
    for (const double sigma_mm : {2.0, kRadiusMm / std::sqrt(2.0), 4.0}) {
      const double x = kRadiusMm * kRadiusMm / (2.0 * sigma_mm * sigma_mm);
      const double exact = kContrastHu * std::numbers::e * x * std::exp(-x);
      // Differences over a voxel blur by h^2 / 12, a tenth of sigma^2 at most here.
      EXPECT_NEAR(Middle(LineResponse(image, Mask(g, 1), sigma_mm, 2)), exact, 0.06 * exact)
          << axis.transpose() << ", sigma " << sigma_mm;
    }
  }
}

TEST(LineResponse, IsSmallOnSheetsAndSteps) {
  const volume::Geometry g = GridOf({0.8, 0.8, 1.0}, 30.0);
  const double middle_mm = CentreOf(g).x();
  const auto sheet =
      PartsInside(g, [&](const Vector3d& p) { return std::abs(p.x() - middle_mm) < 2.0; });
  const auto step = PartsInside(g, [&](const Vector3d& p) { return p.x() > middle_mm - 1.5; });
  EXPECT_NEAR(Middle(LineResponse(sheet, Mask(g, 1), 1.5, 1)), 0.0, 1e-4);
  EXPECT_NEAR(Middle(LineResponse(step, Mask(g, 1), 1.5, 1)), 0.0, 1e-4);
}

TEST(LineResponse, OfTheInvertedImageIsInvertedAndZeroOutsideTheMask) {
  const volume::Geometry g = GridOf({1.0, 0.7, 2.0}, 20.0);
  volume::Grid<float> image(g), inverted(g);
  RandomStream random(3, "values", 0);
  for (std::size_t n = 0; n < image.voxels.size(); ++n) {
    image.voxels[n] = static_cast<float>(random.Normal());
    inverted.voxels[n] = -image.voxels[n];
  }
  Mask half(g);
  for (std::size_t n = half.voxels.size() / 2; n < half.voxels.size(); ++n) half.voxels[n] = 1;
  const auto bright = LineResponse(image, half, 1.4, 1);
  const auto dark = LineResponse(inverted, half, 1.4, 1);
  double most = 0.0;
  for (std::size_t n = 0; n < bright.voxels.size(); ++n) {
    ASSERT_NEAR(bright.voxels[n], -dark.voxels[n], 1e-5);
    ASSERT_TRUE(half.voxels[n] != 0 || bright.voxels[n] == 0.0F);
    most = std::max(most, static_cast<double>(std::abs(bright.voxels[n])));
  }
  EXPECT_GT(most, 0.05);
}

TEST(LineResponse, HasTheSameBitsForAnyNumberOfThreads) {
  const volume::Geometry g = GridOf({1.0, 0.7, 2.0}, 24.0);
  volume::Grid<float> image(g);
  RandomStream random(4, "values", 0);
  for (float& value : image.voxels) value = static_cast<float>(random.Normal());
  EXPECT_EQ(LineResponse(image, Mask(g, 1), 2.0, 1).voxels,
            LineResponse(image, Mask(g, 1), 2.0, 3).voxels);
}

TEST(Blurred, KeepsAConstantUpToTheBorder) {
  const volume::Geometry g = GridOf({1.0, 0.7, 2.0}, 12.0);
  for (const float value : Blurred(volume::Grid<float>(g, 7.0F), 3.0, 1).voxels) {
    ASSERT_NEAR(value, 7.0F, 1e-4F);
  }
}

}  // namespace
}  // namespace acus::segmentation
