#include "acus/run/replay/cost_check.h"

#include <cmath>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace acus::replay {
namespace {

using testing::HasSubstr;
using testing::Not;

CostCheck Check() {
  CostCheck check;
  check.evidence.asked = "--budget force=0.5ms";
  check.evidence.machine = "here";
  check.evidence.measured.step_us_median = 10.0;
  check.evidence.measured.image_ms_p95 = 20.0;
  check.measured.step_us_median = 11.5;
  check.measured.step_us_p999 = 50.0;
  check.measured.image_ms_p95 = 19.0;
  check.machine = "here";
  return check;
}

TEST(CostCheck, ReportsWhatIsMoreAndWhatIsLess) {
  const std::string text = TextOf(Check());
  EXPECT_THAT(text, HasSubstr("--budget force=0.5ms, predicted on here:\n"));
  EXPECT_THAT(text, HasSubstr("force step, median: 11.5 us, predicted 10 us (15 % more)"));
  EXPECT_THAT(text, HasSubstr("image, 95th percentile: 19 ms, predicted 20 ms (5 % less)"));
  EXPECT_THAT(text, Not(HasSubstr("99.9th")));  // Only one of the two has it.
  EXPECT_THAT(text, Not(HasSubstr("another machine")));
}

TEST(CostCheck, SaysIfTheMachineIsAnother) {
  CostCheck check = Check();
  check.machine = "there";
  EXPECT_THAT(TextOf(check), HasSubstr("This is another machine (there)"));
  EXPECT_FALSE(ToJson(check).at("same_machine").get<bool>());
}

TEST(CostCheck, IsEmptyWithoutNumbersInCommon) {
  CostCheck check = Check();
  check.measured = {};
  EXPECT_TRUE(TextOf(check).empty());
}

TEST(CostCheck, KeepsRatiosForPrograms) {
  const nlohmann::json json = ToJson(Check());
  EXPECT_DOUBLE_EQ(json.at("measured_over_predicted").at("step_us_median"), 1.15);
  EXPECT_DOUBLE_EQ(json.at("measured_over_predicted").at("image_ms_p95"), 0.95);
  EXPECT_EQ(json.at("measured_over_predicted").size(), 2U);
  EXPECT_TRUE(json.at("same_machine").get<bool>());
}

TEST(CostOf, TakesMediansAndPercentiles) {
  std::vector<double> steps;
  for (int i = 0; i <= 1000; ++i) steps.push_back(1e-6 * i);
  const scenario::Cost cost = CostOf(steps, std::vector<double>{0.01, 0.02, 0.03});
  EXPECT_NEAR(cost.step_us_median, 500.0, 1e-9);
  EXPECT_NEAR(cost.step_us_p999, 999.0, 1e-6);
  EXPECT_NEAR(cost.image_ms_median, 20.0, 1e-9);
  EXPECT_TRUE(std::isnan(CostOf({}, {}).step_us_median));
}

TEST(CpuClock, CostsLessThanAHundredMicroseconds) {
  EXPECT_GE(CpuClockCostSeconds(), 0.0);
  EXPECT_LT(CpuClockCostSeconds(), 1e-4);
}

}  // namespace
}  // namespace acus::replay
