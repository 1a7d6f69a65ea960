#include "acus/run/replay/plan_table.h"

#include <algorithm>
#include <gmock/gmock.h>
#include <regex>

#include "acus/run/replay/plan_diagram.h"

namespace acus::replay {
namespace {

using simulation::Sleep;
using simulation::StageTimes;
using testing::HasSubstr;

simulation::EffectPlan ForceAndSlice() {
  scenario::Scenario s;
  s.file = "scene.json";
  s.patient.ct = "ct";
  s.patient.labels = "labels";
  s.needle_force.emplace();
  s.ct_slice.emplace();
  return simulation::PlanEffects(s, {.needle_poses = true, .probe_poses = true});
}

StageTimes::Cost Slept(std::int64_t runs, std::int64_t asleep, Sleep why, double seconds) {
  StageTimes::Cost cost{.seconds = seconds, .runs = runs, .asleep = asleep, .asleep_for = {}};
  cost.asleep_for[static_cast<std::size_t>(why)] = asleep;
  return cost;
}

StageTimes SomeTimes() {
  const auto plan = ForceAndSlice();
  StageTimes times(plan);
  times.Of(plan.WriterOf(effects::ports::kForce)) = Slept(1000, 340, Sleep::kNeedleOutside, 0.030);
  times.Of(plan.WriterOf(effects::ports::kCtImage)) = Slept(50, 50, Sleep::kProbeUnseen, 0.010);
  return times;
}

TEST(PlanTable, ReportsWhatIsInOutAndAsleepAndItsShareOfTheTime) {
  const StageTimes times = SomeTimes();
  const std::string text = PlanText(ForceAndSlice(), &times);
  EXPECT_THAT(text, testing::ContainsRegex("needle force +step +in +effect needle_force is called "
                                           "for +1000 +34\\.0 +30\\.0 +30\\.00 +75\\.0"));
  EXPECT_THAT(text, testing::ContainsRegex("CT slice +image +asleep .* 50 +100\\.0 "));
  EXPECT_THAT(text, testing::ContainsRegex("B-mode +image +out +no effect"));
  EXPECT_THAT(text, testing::ContainsRegex("tissue lookup +tissue +needle, labels"));
  EXPECT_THAT(text, HasSubstr("needle force: needle outside the tissue in 34 % of the steps\n"));
  EXPECT_THAT(text,
              HasSubstr("CT slice: the tracker does not see the probe in 100 % of the images\n"));
}

TEST(PlanTable, BeforeARunReportsWhatIsKnown) {
  const std::string text = PlanText(ForceAndSlice(), nullptr);
  EXPECT_THAT(text, testing::ContainsRegex("needle force +step +in +effect"));
  EXPECT_THAT(text, testing::Not(HasSubstr("us/run")));
  EXPECT_THAT(text, testing::Not(HasSubstr("Asleep")));
}

TEST(PlanSvg, DrawsEveryStageOnceGreyIfOutHatchedAsFarAsItSlept) {
  const std::string svg = PlanSvg(ForceAndSlice(), SomeTimes());
  const auto count = [&svg](const std::string& text) {
    int n = 0;
    for (auto at = svg.find(text); at != svg.npos; at = svg.find(text, at + 1)) ++n;
    return n;
  };
  EXPECT_EQ(count("<g class=\"in\">"), 5);
  EXPECT_EQ(count("<g class=\"out\">"), static_cast<int>(ForceAndSlice().stages().size()) - 5);
  EXPECT_EQ(count("fill=\"url(#asleep)\""), 3);  // Two stages and the key.
  EXPECT_EQ(count(">75.0 %, asleep 34 %<"), 1);
  EXPECT_THAT(svg, HasSubstr("asleep in 340 of 1000 runs: needle outside the tissue"));
  for (const char* word : {">ct<", ">labels<", ">needle poses<", ">force<", ">CT image<"}) {
    EXPECT_EQ(count(word), 1) << word;
  }
  EXPECT_EQ(count(">mesh<"), 0);
}

TEST(PlanSvg, HatchesTheRightPartOfAStagesBox) {
  const std::string svg = PlanSvg(ForceAndSlice(), SomeTimes());
  // A box, and right behind it what is hatched in it.
  const std::string rect = R"re(<rect x="([0-9.]+)" y="[0-9.]+" width="([0-9.]+)"[^>]*)re";
  const std::regex pair(rect + R"re(fill="#ffffff"/>\n)re" + rect + R"re(url\(#asleep\)"/>)re");
  std::vector<double> shares;
  for (std::sregex_iterator at(svg.begin(), svg.end(), pair), end; at != end; ++at) {
    const auto number = [&](int i) { return std::stod((*at)[static_cast<std::size_t>(i)]); };
    EXPECT_NEAR(number(3) + number(4), number(1) + number(2), 0.2) << "right sides";
    shares.push_back(number(4) / number(2));
  }
  std::ranges::sort(shares);
  EXPECT_THAT(shares, testing::ElementsAre(testing::DoubleNear(0.34, 2e-3), 1.0));
}

}  // namespace
}  // namespace acus::replay
