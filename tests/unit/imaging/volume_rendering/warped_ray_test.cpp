#include "acus/imaging/volume_rendering/warped_ray.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "support/view_scenes.h"

namespace acus::volume_rendering {
namespace {

using testing_support::At;
using testing_support::DiaphragmMm;
using testing_support::FieldOf;

/// The largest |X + u(X) - x| along rays through the field.
double LargestResidualMm(const breathing::MotionMap& motion, const WarpSettings& settings) {
  double largest_mm = 0.0;
  for (int ray = 0; ray < 40; ++ray) {
    const Eigen::Vector3d from(-60.0 + 3.0 * ray, -90.0, 70.0 - 2.0 * ray);
    const Eigen::Vector3d step = Eigen::Vector3d(0.3 - 0.01 * ray, 1.0, -0.4).normalized();
    WarpedRay warped(motion, settings);
    for (int n = 0; n < 180; ++n) {
      const Eigen::Vector3d world = from + n * step;
      const Eigen::Vector3d rest = warped.RestOf(world, step);
      largest_mm = std::max(largest_mm, (motion.WorldMm(rest) - world).norm());
    }
  }
  return largest_mm;
}

TEST(WarpedRay, FiveIterationsAreAsGoodAsFifty) {
  const auto field = FieldOf(DiaphragmMm);
  const auto motion = At(field, 1.0);
  const double one_mm = LargestResidualMm(motion, {.max_iterations = 1, .tolerance_mm = 0.0});
  const double five_mm = LargestResidualMm(motion, {.max_iterations = 5, .tolerance_mm = 0.0});
  const double fifty_mm = LargestResidualMm(motion, {.max_iterations = 50, .tolerance_mm = 0.0});
  EXPECT_LT(one_mm, 0.5);
  EXPECT_LT(five_mm, 0.1);
  EXPECT_LT(fifty_mm, 1e-4);
}

TEST(WarpedRay, StopsWhereTheToleranceIsMet) {
  const auto field = FieldOf(DiaphragmMm);
  EXPECT_LT(LargestResidualMm(At(field, 1.0), {}), 0.05);
  // Much deeper than normal: strains of 0.6.
  EXPECT_LT(LargestResidualMm(At(field, 2.0), {}), 0.1);
}

TEST(WarpedRay, StaysBoundedWhereTheFieldFolds) {
  const auto field = FieldOf([](const Eigen::Vector3d& place_mm) {
    return Eigen::Vector3d(0.0, 0.0, place_mm[2] > 0.0 ? -30.0 : 30.0);
  });
  const auto motion = At(field, 1.0);
  WarpedRay warped(motion, {});
  for (int n = 0; n < 200; ++n) {
    const Eigen::Vector3d world(0.0, 0.0, -100.0 + n);
    const Eigen::Vector3d rest = warped.RestOf(world, Eigen::Vector3d::UnitZ());
    ASSERT_TRUE(rest.allFinite());
    EXPECT_LE((rest - world).norm(), 30.0 + 1e-3) << world.transpose();
  }
}

}  // namespace
}  // namespace acus::volume_rendering
