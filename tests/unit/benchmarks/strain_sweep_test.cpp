#include "benchmarks/strain_sweep.h"

#include <cmath>
#include <gtest/gtest.h>
#include <map>

namespace acus::benchmarks {
namespace {

TEST(StrainSweep, MoreNodesAndIterationsAreNearerToTheMost) {
  std::map<std::string, std::vector<Row>> by_knob;
  for (const Row& row : StrainSweep().run(true, RunContext())) {
    EXPECT_EQ(row.unusable, "") << row.knob << " " << row.value;
    if (row.error_unit != "N") continue;
    EXPECT_TRUE(std::isfinite(row.error) && row.error >= 0.0) << row.knob << " " << row.value;
    by_knob[row.knob].push_back(row);
  }
  const auto& nodes = by_knob.at("strain_nodes");
  ASSERT_EQ(nodes.size(), 2U);
  EXPECT_GT(nodes[0].error, nodes[1].error);
  EXPECT_LT(nodes[0].step_us_median, nodes[1].step_us_median);
  EXPECT_GT(by_knob.at("law").front().error, 0.001) << "the law changes nothing";
  EXPECT_GT(by_knob.at("strain_iterations").front().error, 0.0);
  EXPECT_EQ(by_knob.at("strain_iterations").back().error, 0.0);
}

}  // namespace
}  // namespace acus::benchmarks
