#include "acus/assess/tuning/knob.h"

#include <algorithm>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "support/layered_folder.h"
#include "support/temporary_folder.h"

namespace acus::tuning {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

std::vector<std::string> NamesOf(const std::vector<Knob>& knobs) {
  std::vector<std::string> names;
  for (const Knob& knob : knobs) names.push_back(knob.name);
  return names;
}

class KnobTest : public testing::Test {
 protected:
  scenario::Scenario Scenario(const std::string& effects) {
    testing_support::WriteLayeredFolder(temporary_.path(), effects);
    return scenario::ReadScenario(temporary_.path() / "scene.json", {});
  }
  testing_support::TemporaryFolder temporary_;
};

constexpr const char* kBendable =
    R"({"needle_force": {"model": "tissue"}, "tissue": {"model": "springs"},
        "needle": {"model": "bendable", "nodes": 30}, "ultrasound": {"model": "beams"}})";

TEST_F(KnobTest, OnlyWhatTheSceneCallsForHasKnobs) {
  const auto all = NamesOf(KnobsOf(Scenario(kBendable), 1000.0));
  for (const char* name : {"needle_nodes", "needle_path_spacing_mm", "spring_path_spacing_mm",
                           "step_rate_hz", "elevation_planes", "speckle", "ultrasound_model"}) {
    EXPECT_THAT(all, Contains(name));
  }
  EXPECT_THAT(all, Not(Contains("contact_spacing_mm")));
  const auto forces = NamesOf(KnobsOf(Scenario(R"({"needle_force": {}})"), 1000.0));
  EXPECT_THAT(forces, testing::ElementsAre("force_model", "step_rate_hz"));
  const auto images = NamesOf(KnobsOf(Scenario(R"({"ultrasound": {}})"), 0.0));
  EXPECT_THAT(images, Not(Contains("step_rate_hz")));
  EXPECT_THAT(images, Not(Contains("speckle")));  // Of beams only.
}

TEST_F(KnobTest, DefaultsAreThoseOfTheSchema) {
  const auto knobs = KnobsOf(Scenario(kBendable), 1000.0);
  const Knob& nodes = KnobNamed(knobs, "needle_nodes");
  EXPECT_EQ(nodes.default_value, 25);
  EXPECT_EQ(nodes.scenario_value, 30);
  EXPECT_EQ(nodes.MostExpensive(), 100);
  EXPECT_FALSE(nodes.falls);
  EXPECT_TRUE(nodes.IsPapers(25));
  EXPECT_FALSE(nodes.IsPapers(100));
  const Knob& spacing = KnobNamed(knobs, "needle_path_spacing_mm");
  EXPECT_EQ(spacing.default_value, 1);
  EXPECT_TRUE(spacing.falls);
}

TEST_F(KnobTest, ValuesOfTheUserAreSortedFromCheapToExpensive) {
  const auto knobs = KnobsOf(Scenario(kBendable), 1000.0);
  using Values = std::vector<nlohmann::json>;
  EXPECT_EQ(KnobFromText(knobs, "needle_nodes=50,15").values, (Values{15, 50}));
  EXPECT_EQ(KnobFromText(knobs, "needle_path_spacing_mm=0.5,3").values, (Values{3, 0.5}));
  EXPECT_EQ(KnobFromText(knobs, "speckle=on,off").values, (Values{false, true}));
  // One value alone is compared with the scenario's own.
  EXPECT_EQ(KnobFromText(knobs, "needle_nodes=50").values, (Values{30, 50}));
  // The knob's own values, and where the scenario stands.
  EXPECT_EQ(KnobFromText(knobs, "needle_nodes").values, (Values{8, 15, 25, 30, 50, 100}));
  EXPECT_EQ(KnobFromText(knobs, "tissue_model=springs,displacement_functions").values,
            (Values{"displacement_functions", "springs"}));
}

TEST_F(KnobTest, TypingMistakesAreReportedWithWhatThereIs) {
  const auto knobs = KnobsOf(Scenario(kBendable), 1000.0);
  EXPECT_THAT([&] { KnobFromText(knobs, "needle_node=15"); },
              ThrowsMessage<InputError>(
                  AllOf(HasSubstr("did you mean needle_nodes?"), HasSubstr("elevation_planes"))));
  EXPECT_THAT([&] { KnobFromText(knobs, "tissue_model=spring"); },
              ThrowsMessage<InputError>(
                  AllOf(HasSubstr("did you mean springs?"), HasSubstr("fe_2d, fe_3d"))));
  EXPECT_THAT([&] { KnobFromText(knobs, "needle_nodes=many"); },
              ThrowsMessage<InputError>(HasSubstr("many is not a number")));
  EXPECT_THAT([&] { KnobFromText(knobs, "needle_nodes=15,,50"); },
              ThrowsMessage<InputError>(HasSubstr("a value is missing")));
  EXPECT_THAT([&] { KnobFromText(knobs, "needle_nodes=30"); },
              ThrowsMessage<InputError>(HasSubstr("at least two values")));
}

TEST_F(KnobTest, EveryValueBecomesAChangeThatTheScenarioTakes) {
  const auto scenario = Scenario(kBendable);
  const auto knobs = KnobsOf(scenario, 1000.0);
  int num_changes = 0;
  for (const Knob& knob : knobs) {
    for (const auto& value : knob.values) {
      const auto overrides = OverridesOf(knobs, {{knob.name, value}});
      EXPECT_EQ(overrides.size(), knob.pointers.size());
      // Models lean on other effects; those that do not fit this scene are left out when planned.
      if (overrides.empty() || knob.name.ends_with("_model")) continue;
      const auto changed = scenario::ReadScenario(scenario.file, overrides);
      EXPECT_EQ(changed.effective.at(nlohmann::json::json_pointer(knob.pointers.front())), value)
          << knob.name;
      ++num_changes;
    }
  }
  EXPECT_GT(num_changes, 30);
}

}  // namespace
}  // namespace acus::tuning
