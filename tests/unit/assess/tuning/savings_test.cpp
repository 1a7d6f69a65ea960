#include "acus/assess/tuning/savings.h"

#include <gmock/gmock.h>

namespace acus::tuning {
namespace {

using testing::HasSubstr;

SettingResult ForceSetting(const char* knob, const nlohmann::json& value, Estimate step_us,
                           Estimate error_n, bool is_reference = false) {
  SettingResult setting;
  setting.knob = knob;
  setting.setting = {{knob, value}};
  setting.is_reference = is_reference;
  setting.step_us_median = step_us;
  setting.force_felt_n = {1.0, 0.0, 3};
  setting.force_rms_n = error_n;
  return setting;
}

SettingResult ImageSetting(const char* knob, const nlohmann::json& value, Estimate image_ms,
                           Estimate grey, bool is_reference = false) {
  SettingResult setting;
  setting.knob = knob;
  setting.setting = {{knob, value}};
  setting.is_reference = is_reference;
  setting.image_ms_median = image_ms;
  setting.image_rms_grey = grey;
  return setting;
}

Knob KnobWith(const char* name, ActsOn acts_on, std::vector<nlohmann::json> values) {
  Knob knob;
  knob.name = name;
  knob.acts_on = acts_on;
  knob.values = std::move(values);
  return knob;
}

/// Two numbers, a part that is on or off, a model, other speckle.
SweepResult Sweep() {
  SweepResult result;
  result.knobs = {KnobWith("needle_nodes", ActsOn::kForce, {8, 15, 50}),
                  KnobWith("comet_tail", ActsOn::kImage, {false, true}),
                  KnobWith("ultrasound_model", ActsOn::kImage, {"columns_2010", "beams"}),
                  KnobWith("speckle", ActsOn::kImage, {false, true})};
  result.settings = {ForceSetting("needle_nodes", 8, {5, 0.5, 3}, {0.2, 0.02, 3}),
                     ForceSetting("needle_nodes", 15, {49, 3, 3}, {0.01, 0.02, 3}),
                     ForceSetting("needle_nodes", 50, {50, 2, 3}, {0, 0, 3}, true),
                     ImageSetting("comet_tail", false, {8, 0.1, 3}, {0.5, 0.1, 3}),
                     ImageSetting("comet_tail", true, {10, 0.1, 3}, {0, 0, 3}, true),
                     ImageSetting("ultrasound_model", "columns_2010", {1, 0.1, 3}, {40, 1, 3}),
                     ImageSetting("ultrasound_model", "beams", {10, 0.1, 3}, {0, 0, 3}, true),
                     ImageSetting("speckle", false, {9, 0.1, 3}, {30, 24, 3}),
                     ImageSetting("speckle", true, {10, 0.1, 3}, {0, 0, 3}, true)};
  return result;
}

TEST(Savings, AreSortedWithWhatIsNotDistinguishableLast) {
  const SweepResult result = Sweep();
  const auto savings = SavingsOf(result);
  ASSERT_EQ(savings.size(), 5U);
  EXPECT_EQ(savings[0].setting, &result.settings[0]);
  EXPECT_NEAR(savings[0].saved_percent.mean, 90.0, 1e-12);
  EXPECT_NEAR(savings[0].saved_percent.half_width, 10.0 * std::hypot(0.1, 0.04), 1e-12);
  EXPECT_EQ(SavedText(savings[0]), "90 % \u00B1 1");
  EXPECT_EQ(LossText(savings[0]), "0.2 N \u00B1 0.02");
  EXPECT_THAT(NoticedText(savings[0]), HasSubstr("20 % of the force felt"));
  const Saving& last = savings.back();
  EXPECT_EQ(last.setting, &result.settings[1]);
  EXPECT_EQ(SavedText(last), "not distinguishable") << "49 +- 3 against 50 +- 2";
  EXPECT_EQ(LossText(last), "at most 0.03 N; not distinguishable from 0");
}

TEST(Savings, ModelsAndOtherSpeckleAreDifferences) {
  const SweepResult result = Sweep();
  const auto savings = SavingsOf(result);
  const SavingsTable losses = TableOf(savings, false), others = TableOf(savings, true);
  ASSERT_EQ(losses.rows.size(), 3U);
  ASSERT_EQ(others.rows.size(), 2U);
  EXPECT_EQ(others.header[3], "difference, RMS");
  EXPECT_EQ(others.rows[0][0], "ultrasound_model columns_2010 instead of beams");
  EXPECT_EQ(losses.rows[1][0], "comet_tail off instead of on") << "no JSON";
  EXPECT_EQ(losses.rows[1][4], "nothing: less than a grey level");
  const report::Plot plot = SavingsPlot(savings);
  ASSERT_EQ(plot.series.size(), 2U);
  EXPECT_EQ(plot.series[0].x.size(), 1U) << "what is not distinguishable is not drawn";
  EXPECT_EQ(plot.series[1].x.size(), 1U) << "nor are differences";
}

TEST(Savings, OneRunHasNoInterval) {
  SweepResult result = Sweep();
  for (SettingResult& setting : result.settings) {
    setting.step_us_median = {setting.step_us_median.mean, NAN, 1};
    setting.force_rms_n = {setting.force_rms_n.mean, NAN, setting.force_rms_n.count == 0 ? 0 : 1};
  }
  const auto savings = SavingsOf(result);
  EXPECT_EQ(SavedText(savings[0]), "90 % in one run");
  EXPECT_EQ(LossText(savings[0]), "0.2 N");
}

}  // namespace
}  // namespace acus::tuning
