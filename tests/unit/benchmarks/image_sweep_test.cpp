#include "benchmarks/image_sweep.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <map>

#include "benchmarks/image_scene.h"

namespace acus::benchmarks {
namespace {

TEST(ImageSweep, TissueIsFoundWhereItWasAtRest) {
  const Eigen::Vector3d tip_mm(27.0, 26.0, 15.0);
  const PressedTissue tissue(tip_mm, 40, 2.0);
  for (const double aside_mm : {0.0, 3.0, 9.0}) {
    const Eigen::Vector3d place = tip_mm + Eigen::Vector3d(aside_mm, -0.5 * aside_mm, 1.0);
    const Eigen::Vector3d rest = tissue.RestInCtMm(place, place);
    const double near = std::exp(-(rest - tip_mm).squaredNorm() / 100.0);
    EXPECT_NEAR((rest + 2.0 * near * Eigen::Vector3d(0.7, 0.7, 0.1) - place).norm(), 0.0, 1e-6);
  }
}

TEST(ImageSweep, ExpensiveSettingsAreNearerToTheMostExpensive) {
  setenv("ACUS_CONFIGS", (std::filesystem::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
  const std::vector<Row> rows = ImageSweep().run(true, RunContext());
  std::map<std::string, std::vector<Row>> by_knob;
  for (const Row& row : rows) {
    EXPECT_TRUE(std::isfinite(row.error) && row.error >= 0.0) << row.knob << " " << row.value;
    EXPECT_GT(row.step_us_median, 0.0);
    if (row.error_unit.ends_with(", pixels")) by_knob[row.knob].push_back(row);
  }
  for (const char* knob : {"lines", "samples", "warp_iterations", "point_spread_reach"}) {
    const auto& swept = by_knob.at(knob);
    EXPECT_LT(swept.back().error, swept.front().error) << knob;
  }
  const auto& spacing = by_knob.at("warp_spacing_mm");
  EXPECT_LT(spacing.front().error, spacing.back().error);
  double speckle = 0.0;
  for (const Row& row : by_knob.at("effect")) {
    if (row.value == "no speckle") speckle = row.error;
  }
  EXPECT_GT(speckle, 3.0) << "most of what is in the image";
}

}  // namespace
}  // namespace acus::benchmarks
