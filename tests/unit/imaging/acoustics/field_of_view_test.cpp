#include "acus/imaging/acoustics/field_of_view.h"

#include <cmath>
#include <gtest/gtest.h>

namespace acus::acoustics {
namespace {

TEST(FieldOfView, OfALinearProbeIsARectangle) {
  Probe probe = DefaultProbe();
  probe.width_mm = 40.0;
  probe.depth_mm = 60.0;
  EXPECT_TRUE(IsInFieldOfView(probe, {19.9, 59.9}));
  EXPECT_FALSE(IsInFieldOfView(probe, {20.1, 30.0}));
  EXPECT_FALSE(IsInFieldOfView(probe, {0.0, 60.1}));
  EXPECT_FALSE(IsInFieldOfView(probe, {0.0, -0.1}));
  EXPECT_TRUE(IsInFieldOfView(probe, {0.0, 60.0 + 1e-10})) << "the last row, rounded";
  EXPECT_TRUE(IsInFieldOfView(probe, {0.0, -1e-10})) << "the first row, rounded";
  EXPECT_EQ(DepthBelowFaceMm(probe, {7.0, 33.0}), 33.0);
}

TEST(FieldOfView, OfACurvedProbeIsTheFanOfItsLines) {
  Probe probe = DefaultProbe();
  probe.kind = ProbeKind::kCurvilinear;
  probe.radius_mm = 50.0;
  probe.field_of_view_rad = 1.0;
  probe.depth_mm = 100.0;
  probe.scan_lines = 65;
  probe.samples_per_line = 101;
  const ScanGrid grid = BeamGridOf(probe);
  for (const std::size_t line : {std::size_t{1}, std::size_t{20}, std::size_t{63}}) {
    for (const double depth_mm : {0.5, 40.0, 99.5}) {
      const Eigen::Vector2d place = grid.start_mm[line] + depth_mm * grid.direction[line];
      EXPECT_TRUE(IsInFieldOfView(probe, place)) << line << ' ' << depth_mm;
      EXPECT_NEAR(DepthBelowFaceMm(probe, place), depth_mm, 1e-9);
    }
    const Eigen::Vector2d beyond = grid.start_mm[line] + 100.5 * grid.direction[line];
    EXPECT_FALSE(IsInFieldOfView(probe, beyond));
  }
  const Eigen::Vector2d across(std::cos(0.5), -std::sin(0.5));  // Of the outermost line.
  const Eigen::Vector2d edge = grid.start_mm[64] + 50.0 * grid.direction[64];
  EXPECT_FALSE(IsInFieldOfView(probe, edge + 0.1 * across));
  EXPECT_TRUE(IsInFieldOfView(probe, edge - 0.1 * across));
}

}  // namespace
}  // namespace acus::acoustics
