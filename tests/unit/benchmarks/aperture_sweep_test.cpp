#include "benchmarks/aperture_sweep.h"

#include <cmath>
#include <gtest/gtest.h>
#include <map>

namespace acus::benchmarks {
namespace {

TEST(ApertureSweep, ExpensiveSettingsAreNearerToTheMostExpensive) {
  std::map<std::string, std::vector<Row>> by_knob;
  for (const Row& row : ApertureSweep().run(true, RunContext())) {
    EXPECT_TRUE(std::isfinite(row.error) && row.error >= 0.0) << row.knob << " " << row.value;
    EXPECT_GT(row.step_us_median, 0.0);
    if (row.error_unit.ends_with(", pixels")) by_knob[row.knob].push_back(row);
  }
  for (const char* knob : {"aperture_rays", "elevation_planes", "lines", "samples"}) {
    const auto& swept = by_knob.at(knob);
    ASSERT_EQ(swept.size(), 2U);
    EXPECT_LT(swept.back().error, swept.front().error) << knob;
    EXPECT_GT(swept.front().error, 0.05) << knob << ": nothing changes";
  }
  // Planes far out weigh nothing: no echo is lost to what they see.
  EXPECT_LT(by_knob.at("elevation_planes").back().error, 0.1);
  EXPECT_TRUE(by_knob.at("aperture_rays").back().is_default);
  EXPECT_FALSE(by_knob.at("aperture_rays").front().is_default);
  for (const Row& row : by_knob.at("effect")) EXPECT_GT(row.error, 0.0) << row.value;
}

}  // namespace
}  // namespace acus::benchmarks
