#include "benchmarks/needle_sweep.h"

#include <cmath>
#include <gtest/gtest.h>
#include <map>

namespace acus::benchmarks {
namespace {

TEST(NeedleSweep, OnlyNodesMatterAndTheirErrorFallsWithTheirSquare) {
  const std::vector<Row> rows = NeedleSweep().run(true, {});
  std::map<std::string, double> force_n;
  double at_default_n = 0.0;
  for (const Row& row : rows) {
    EXPECT_GE(row.error, 0.0);
    if (row.knob == "max_iterations" && row.value == "1") continue;
    EXPECT_EQ(row.unusable, "") << row.knob << " " << row.value;
    if (row.error_unit != "N") continue;
    EXPECT_GT(row.step_us_median, 0.0);
    if (row.knob == "num_nodes") force_n[row.value] = row.error;
    if (row.knob == "num_nodes" && row.is_default) at_default_n = row.error;
  }
  ASSERT_GT(at_default_n, 0.0);
  EXPECT_LT(at_default_n, 0.01);
  EXPECT_NEAR(force_n.at("25") / force_n.at("50"), std::pow(49.0 / 24.0, 2), 0.5);
  for (const Row& row : rows) {
    if (row.knob == "num_nodes" || row.error_unit != "N") continue;
    EXPECT_NEAR(row.error, at_default_n, 0.05 * at_default_n) << row.knob << " " << row.value;
  }
}

}  // namespace
}  // namespace acus::benchmarks
