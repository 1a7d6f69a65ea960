#include "acus/patient/phantom/hands/markers.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/csv.h"
#include "support/temporary_folder.h"
#include "unit/patient/phantom/presets.h"

namespace acus::phantom {
namespace {

TEST(PlaceMarkers, PutsThemOnTheSkinAroundTheEntry) {
  const Case c("lumbar", 1);
  const auto markers = PlaceMarkers(c.field, c.plan, c.config.markers, {});
  ASSERT_EQ(markers.size(), 8U);
  for (const NamedPoint& marker : markers) {
    EXPECT_NEAR(c.field.SkinDistanceMm(marker.position_mm), 0.0, 1e-3) << marker.name;
    const double distance = (marker.position_mm - c.plan.entry_ct_mm).norm();
    EXPECT_GT(distance, 0.7 * c.config.markers.radius_mm) << marker.name;
    EXPECT_LT(distance, 1.3 * c.config.markers.radius_mm) << marker.name;
  }
}

TEST(PlaceMarkers, SpreadsThemEvenlyAroundTheEntry) {
  const Case c("lumbar", 1);
  const auto markers = PlaceMarkers(c.field, c.plan, c.config.markers, {});
  const auto angle = [&](const NamedPoint& marker) {
    const Eigen::Vector3d out = marker.position_mm - c.plan.entry_ct_mm;
    return std::atan2(out.dot(c.plan.lateral()), out.dot(c.plan.heading));
  };
  for (std::size_t i = 0; i < markers.size(); ++i) {
    const double step = angle(markers[(i + 1) % markers.size()]) - angle(markers[i]);
    EXPECT_NEAR(std::remainder(step - 2.0 * M_PI / 8.0, 2.0 * M_PI), 0.0, 0.1) << markers[i].name;
  }
}

TEST(PlaceMarkers, IsPulledInByTheBorderOfTheVolumeAndSaysSoIfNothingIsLeft) {
  const volume::LabelMap labels = SyntheticBody({90, 70, 14}, 4.0);  // 52 mm high.
  const LabelMapField field(labels);
  InsertionPlan plan;
  plan.entry_ct_mm = Eigen::Vector3d(0, 105, 0);
  plan.skin_normal = Eigen::Vector3d::UnitY();
  plan.heading = Eigen::Vector3d::UnitZ();
  MarkerSettings settings;
  const auto markers = PlaceMarkers(field, plan, settings, {});
  EXPECT_GE(markers.size(), 3U);
  for (const NamedPoint& marker : markers) {
    EXPECT_TRUE(field.bounds_ct_mm().contains(marker.position_mm)) << marker.name;
  }
  plan.entry_ct_mm = Eigen::Vector3d(0, 400, 0);
  EXPECT_THROW(PlaceMarkers(field, plan, settings, {}), NoAnswerError);
}

TEST(LocateOnMannequin, ErrsAsStated) {
  MarkerSettings settings = Preset("lumbar").markers;
  settings.fle_mm = 0.7;
  const std::vector<NamedPoint> markers(40, NamedPoint{"M", Eigen::Vector3d(10, 20, 30)});
  const Eigen::Vector3d truth = settings.reference_from_ct * Eigen::Vector3d(10, 20, 30);
  double squares = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  constexpr int kSeeds = 250;
  const double n = 40.0 * kSeeds;
  for (int seed = 0; seed < kSeeds; ++seed) {
    for (const NamedPoint& marker :
         LocateOnMannequin(markers, settings, static_cast<std::uint64_t>(seed))) {
      squares += (marker.position_mm - truth).squaredNorm();
      mean += (marker.position_mm - truth) / n;
    }
  }
  // Chi-square with 3 n degrees of freedom: relative standard error of the root is 1 / sqrt(6 n).
  EXPECT_NEAR(std::sqrt(squares / n), 0.7, 4.0 * 0.7 / std::sqrt(6.0 * n));
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 4.5 * 0.7 / std::sqrt(3.0 * n));
  settings.fle_mm = 0.0;
  EXPECT_EQ(LocateOnMannequin(markers, settings, 1)[0].position_mm, truth);
}

TEST(WritePoints, CanBeReadBackToTheBit) {
  const testing_support::TemporaryFolder folder;
  WritePoints(folder / "points.csv", {{"a", {1.0 / 3.0, -2e-7, 1e5}}, {"b", {0, 1, 2}}});
  const CsvTable table(folder / "points.csv");
  EXPECT_EQ(table.Texts("name"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(table.Numbers("x_mm")[0], 1.0 / 3.0);
  EXPECT_EQ(table.Numbers("y_mm")[0], -2e-7);
  EXPECT_EQ(table.Numbers("z_mm")[1], 2.0);
}

}  // namespace
}  // namespace acus::phantom
