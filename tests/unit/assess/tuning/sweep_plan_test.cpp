#include "acus/assess/tuning/sweep_plan.h"

#include <gmock/gmock.h>
#include <map>
#include <set>

#include "acus/assess/tuning/budget.h"
#include "acus/assess/tuning/case_run.h"
#include "acus/base/core/error.h"
#include "acus/base/core/version.h"
#include "support/sweep_folder.h"

namespace acus::tuning {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::MatchesRegex;
using testing::Pair;
using testing::StartsWith;
using testing::ThrowsMessage;
using testing_support::kBendableEffects;

class PlanTest : public testing_support::SweepFolder {};

TEST_F(PlanTest, EveryKnobIsVariedByItselfAndItsMostExpensiveValueComesFirst) {
  Make(kBendableEffects);
  request_.knobs = {"needle_nodes=15,50,25", "needle_path_spacing_mm=2,1"};
  request_.repetitions = 2;
  const SweepPlan plan = Plan();
  EXPECT_EQ(plan.cases.size(), 2U * (3 + 2));
  EXPECT_EQ(plan.cases[0].name, "needle_nodes-50-r0");
  EXPECT_TRUE(plan.cases[0].is_reference);
  EXPECT_EQ(plan.cases[1].setting, (Setting{{"needle_nodes", 15}}));
  EXPECT_EQ(plan.cases[1].reference_case, plan.cases[0].name);
  std::set<std::string> names;
  for (const Case& one : plan.cases) names.insert(one.name);
  EXPECT_EQ(names.size(), plan.cases.size());
  // Nothing is random in this scene: one reference serves all repetitions.
  int references = 0;
  for (const Case& one : plan.cases) references += one.is_reference;
  EXPECT_EQ(references, 2);
  EXPECT_NEAR(plan.step_period_ms, 1.0, 1e-12);
  EXPECT_NEAR(plan.seconds, 1.0, 1e-9);
  EXPECT_EQ(plan.image_period_ms, 0.0);
}

TEST_F(PlanTest, ValuesThatTheSceneCannotTakeAreOmittedOrRefused) {
  Make(kBendableEffects);
  request_.knobs = {"tissue_model"};
  // No mesh, no corridor, and the needle's force comes from the tissue: springs remain.
  EXPECT_THAT([&] { Plan(); }, ThrowsMessage<InputError>(HasSubstr("only one of its values")));
  request_.knobs = {"tissue_model=springs,fe_3d"};
  EXPECT_THAT([&] { Plan(); }, ThrowsMessage<InputError>(AllOf(HasSubstr("tissue_model=fe_3d"),
                                                               HasSubstr("/patient/mesh"))));
  request_.knobs = {};
  const SweepPlan plan = Plan();
  EXPECT_FALSE(plan.left_out.empty());
  for (const Knob& knob : plan.knobs) EXPECT_GE(knob.values.size(), 2U) << knob.name;
}

TEST_F(PlanTest, JointlyAllCombinationsOrASpreadSubset) {
  Make(kBendableEffects);
  request_.knobs = {"needle_nodes=15,25,50", "needle_path_spacing_mm=4,2,1",
                    "step_rate_hz=500,1000"};
  request_.jointly = true;
  const SweepPlan all = Plan();
  EXPECT_EQ(all.cases.size(), 18U);
  EXPECT_FALSE(all.is_subset);
  EXPECT_EQ(all.cases[0].setting,
            (Setting{{"needle_nodes", 50}, {"needle_path_spacing_mm", 1}, {"step_rate_hz", 1000}}));
  request_.most_combinations = 7;
  const SweepPlan some = Plan();
  EXPECT_TRUE(some.is_subset);
  EXPECT_EQ(some.combinations, 18.0);
  // The subset, the most expensive of all, and the scenario's own.
  EXPECT_GE(some.cases.size(), 7U);
  EXPECT_LE(some.cases.size(), 9U);
  EXPECT_TRUE(some.cases[0].is_reference);
}

TEST_F(PlanTest, JointlyTheScenariosOwnSettingComesAfterTheMostExpensive) {
  Make(kBendableEffects);
  request_.knobs = {"needle_nodes=8,15,25,50", "step_rate_hz=500,1000,2000"};
  request_.jointly = true;
  request_.most_combinations = 2;
  const SweepPlan plan = Plan();
  ASSERT_GE(plan.cases.size(), 2U);
  EXPECT_EQ(plan.cases[0].setting, (Setting{{"needle_nodes", 50}, {"step_rate_hz", 2000}}));
  EXPECT_EQ(plan.cases[1].setting, (Setting{{"needle_nodes", 15}, {"step_rate_hz", 1000}}));
}

TEST_F(PlanTest, ALiveSessionWaitsForWhatTheSceneHas) {
  request_.knobs = {"step_rate_hz=500,1000"};
  Make(kBendableEffects);
  Goal goal = LiveGoalOf(Plan(), context_);
  EXPECT_TRUE(goal.force);
  EXPECT_FALSE(goal.image);
  context_.overwrite = true;
  request_.knobs = {};
  Make(R"({"ultrasound": {}})");
  goal = LiveGoalOf(Plan(), context_);
  EXPECT_FALSE(goal.force);
  EXPECT_TRUE(goal.image);
}

TEST_F(PlanTest, RatesAreTakenUpToTheirLimits) {
  session::Session session = Insertion();
  session.needle.resize(3);
  EXPECT_EQ(Resampled(session, 1e5).needle.size(), 201U);
  EXPECT_EQ(Resampled(session, 10.0).needle.size(), 1U);
  for (const double rate_hz : {100'001.0, 9.99}) {
    EXPECT_THAT([&] { Resampled(session, rate_hz); },
                ThrowsMessage<InputError>(HasSubstr("step_rate_hz")));
  }
}

TEST(SeedChanges, AddToTheScenariosOwnSeeds) {
  scenario::Scenario scenario;
  scenario.ultrasound.emplace().seed = 3;
  scenario.breathing.emplace().pattern.seed = 7;
  const auto seeds = [&] {
    std::map<std::string, int> out;
    for (const auto& change : SeedChanges(scenario, 5)) out[change.pointer] = change.value;
    return out;
  };
  EXPECT_THAT(seeds(), ElementsAre(Pair("/effects/ultrasound/seed", 8))) << "an even breath";
  scenario.breathing->pattern.level_spread = 0.1;
  EXPECT_THAT(seeds(), ElementsAre(Pair("/effects/breathing/pattern/seed", 12),
                                   Pair("/effects/ultrasound/seed", 8)));
}

TEST_F(PlanTest, WrongRequestsAreReportedAtOnce) {
  Make(kBendableEffects);
  request_.knobs = {"needle_nodes=15,50", "needle_nodes=25,50"};
  EXPECT_THAT([&] { Plan(); }, ThrowsMessage<InputError>(HasSubstr("given twice")));
  request_.knobs = {"needle_nodes=3,50"};
  EXPECT_THAT([&] { Plan(); }, ThrowsMessage<InputError>(HasSubstr("/effects/needle/nodes")));
  request_.knobs = {"needle_nodes=15,50"};
  request_.scene.from_s = 1.5;
  EXPECT_THAT([&] { Plan(); }, ThrowsMessage<InputError>(HasSubstr("1 s long")));
}

TEST_F(PlanTest, AnotherSweepHasAnotherIdentity) {
  Make(kBendableEffects);
  request_.knobs = {"needle_nodes=15,50"};
  const auto identity = IdentityOf(Plan());
  EXPECT_EQ(IdentityOf(Plan()), identity);
  EXPECT_THAT(identity.at("build").get<std::string>(),
              AllOf(StartsWith(Version()), MatchesRegex(".+, program [0-9a-f]{12}")));
  request_.repetitions = 5;  // More of the same.
  EXPECT_EQ(IdentityOf(Plan()), identity);
  request_.seed = 3;
  EXPECT_NE(IdentityOf(Plan()), identity);
  request_.seed = 0;
  request_.knobs = {"needle_nodes=15,25"};
  EXPECT_NE(IdentityOf(Plan()), identity);
  request_.knobs = {"needle_nodes=15,50"};
  request_.scene.changes = {scenario::ParseOverride("/effects/needle/tip_stiffness_n_per_mm=0.7")};
  EXPECT_NE(IdentityOf(Plan()), identity);
}

TEST(SpreadCombinations, AreAllOfThemWhereThereIsRoom) {
  const auto all = SpreadCombinations({2, 3, 2}, 12, 1);
  EXPECT_EQ(std::set<std::vector<int>>(all.begin(), all.end()).size(), 12U);
}

TEST(SpreadCombinations, TakeEveryValueAsOftenAsAnyOtherAndNothingTwice) {
  const std::vector<int> sizes = {5, 6, 2, 8, 7};
  for (const std::uint64_t seed : {0U, 1U, 2U}) {
    const auto some = SpreadCombinations(sizes, 100, seed);
    ASSERT_EQ(some.size(), 100U);
    EXPECT_EQ(std::set<std::vector<int>>(some.begin(), some.end()).size(), 100U);
    EXPECT_EQ(some, SpreadCombinations(sizes, 100, seed));
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      std::map<int, int> count;
      for (const auto& indices : some) ++count[indices[k]];
      for (int index = 0; index < sizes[k]; ++index) {
        EXPECT_NEAR(count[index], 100.0 / sizes[k], 6.0) << "knob " << k << " index " << index;
      }
    }
  }
  EXPECT_NE(SpreadCombinations(sizes, 100, 0), SpreadCombinations(sizes, 100, 1));
  // Nearly all of few: the last ones are found, too, for any seed.
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    EXPECT_EQ(SpreadCombinations({3, 3}, 8, seed).size(), 8U);
    EXPECT_EQ(SpreadCombinations({2, 2, 5}, 19, seed).size(), 19U);
  }
  const auto many = SpreadCombinations({10, 10, 10, 10, 10}, 99'999, 3);
  EXPECT_EQ(std::set<std::vector<int>>(many.begin(), many.end()).size(), 99'999U);
}

}  // namespace
}  // namespace acus::tuning
