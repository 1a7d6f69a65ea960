#include "acus/assess/regression/comparison/compare_metrics.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace acus::comparison {
namespace {

using nlohmann::json;

json Document(json value, const char* unit = "mm") {
  return {{"metrics", {{{"name", "depth"}, {"unit", unit}, {"value", std::move(value)}}}}};
}

Check Compared(const json& a, const json& b, const MetricTolerances& tolerances = {}) {
  const auto checks = CompareMetrics(a, "a.json", b, "b.json", tolerances);
  EXPECT_EQ(checks.size(), 1U);
  return checks.front();
}

TEST(CompareMetrics, AMissingValueEqualsOnlyAMissingOne) {
  EXPECT_TRUE(Compared(Document(nullptr), Document(nullptr)).passed);
  EXPECT_FALSE(Compared(Document(nullptr), Document(1.0)).passed);
  EXPECT_FALSE(Compared(Document(1.0), Document(nullptr)).passed);
}

TEST(CompareMetrics, ADifferenceOfTheToleranceStillPasses) {
  MetricTolerances tolerances;
  tolerances.absolute = 0.25;
  tolerances.relative = 0.0;
  EXPECT_TRUE(Compared(Document(1.0), Document(1.25), tolerances).passed);
  EXPECT_FALSE(Compared(Document(1.0), Document(1.26), tolerances).passed);
  EXPECT_FALSE(Compared(Document(1.0), Document(1.0, "m"), tolerances).passed) << "units";
}

}  // namespace
}  // namespace acus::comparison
