// An effect that is off and one that is on and has nothing to do give identical bits: every effect
// in every model, beside every other.
#include <gtest/gtest.h>
#include <set>

#include "acus/base/core/error.h"
#include "support/effects_patient.h"
#include "support/effects_run.h"

namespace acus::simulation {
namespace {

using nlohmann::json;
using testing_support::EffectChoice;
using testing_support::Hands;
using testing_support::Outputs;

constexpr int kSteps = 320;

const testing_support::EffectsPatient& EffectsPairwisePatient() {
  static const testing_support::EffectsPatient patient;
  return patient;
}

Outputs RunOf(const json& effects, const Hands& hands) {
  const auto s = EffectsPairwisePatient().With(effects);
  RunContext context;
  const Scene scene =
      LoadScene(s, PlanEffects(s, {.needle_poses = true, .probe_poses = true}), context);
  testing_support::EffectsRun run(scene);
  Outputs out;
  run.Steps(kSteps, hands, &out);
  run.RenderImages(run.Now(), out);
  return out;
}

/// An effect, and hands that leave it nothing to do. Images are for the eye: whatever they show,
/// nothing that is felt or seen elsewhere may change.
struct Idle {
  json effects;
  Hands hands;
};
Idle IdleOf(const EffectChoice& choice) {
  Idle idle{choice.effects, {}};
  if (choice.effect == "needle_force" || choice.effect == "needle" || choice.effect == "fluid")
    idle.hands.needle_in = false;
  if (choice.effect == "probe_force") idle.hands.probe_on = false;
  if (choice.effects.contains("tissue")) idle.hands = {.needle_in = false, .probe_on = false};
  if (choice.effect == "breathing") idle.effects["breathing"]["amplitude"] = 0;
  if (choice.effect == "pulsating_vessels") idle.effects[choice.effect]["radial_strain"] = 0;
  if (choice.effect == "peristalsis") idle.effects[choice.effect]["contraction"] = 0;
  if (choice.effect == "pain_reaction") idle.effects[choice.effect]["amplitude_mm"] = 0;
  return idle;
}

/// What the first scene's own effects give, out of all that a scene gave.
Outputs Common(Outputs out, const json& effects) {
  const auto keep = [&effects](const char* effect, auto& data) {
    if (!effects.contains(effect)) data.clear();
  };
  keep("needle_force", out.needle_force);
  keep("needle", out.needle);
  keep("probe_force", out.probe_force);
  keep("tissue", out.tissue);
  keep("ultrasound", out.ultrasound);
  keep("ct_slice", out.ct_slice);
  std::erase_if(out.effects,
                [&effects](const auto& image) { return !effects.contains(image.first); });
  return out;
}

/// The B-mode is part of the view in 3D: there it is meant to be seen.
bool IsPartOf(const std::string& added, const json& effects) {
  return added == "ultrasound" && effects.contains("view_3d");
}

/// Every effect in its first model beside every other in all of its models, and the other way
/// round.
TEST(Effects, OffAndIdleGiveIdenticalBitsInEveryPair) {
  const auto all = testing_support::AllEffectChoices();
  std::map<std::string, std::string> first;
  for (const EffectChoice& choice : all) first.emplace(choice.effect, choice.name);
  std::map<std::string, Outputs> alone;
  std::set<std::pair<std::string, std::string>> effects_seen;
  int pairs = 0;
  for (const EffectChoice& a : all) {
    for (const EffectChoice& b : all) {
      if (a.effect == "breathing" || a.effects.contains(b.effect)) continue;
      if (first.at(a.effect) != a.name && first.at(b.effect) != b.name) continue;
      const Idle idle = IdleOf(b);
      if (!testing_support::Agree(a.effects, idle.effects) || IsPartOf(b.effect, a.effects))
        continue;
      SCOPED_TRACE(a.name + ", with " + b.name + " idle");
      json both = a.effects;
      both.update(idle.effects);
      const std::string key = Message(a.name, idle.hands.needle_in, idle.hands.probe_on);
      if (!alone.contains(key)) alone[key] = RunOf(a.effects, idle.hands);
      ASSERT_EQ(Common(RunOf(both, idle.hands), a.effects), alone[key]);
      effects_seen.insert({a.effect, b.effect});
      ++pairs;
    }
  }
  std::printf("  %d pairs of models, %zu of effects\n", pairs, effects_seen.size());
  EXPECT_GT(pairs, 200);
  EXPECT_GT(effects_seen.size(), 50U);
}

TEST(Effects, ActiveOnesDoShow) {
  // The comparison above could fail: each effect, awake, changes what it is meant to change.
  const json images = {{"ct_slice", json::object()}, {"ultrasound", json::object()}};
  const Outputs before = RunOf(images, {});
  json moved = images;
  moved["breathing"] = {{"motion", "sinusoid"}};
  EXPECT_NE(RunOf(moved, {}).ct_slice, before.ct_slice);
  moved = images;
  moved["tissue"] = {{"model", "springs"}};
  EXPECT_NE(RunOf(moved, {}).ultrasound, before.ultrasound);
  const json felt = {{"needle_force", {{"model", "layered"}}},
                     {"probe_force", {{"model", "vidal"}}}};
  const Outputs at_rest = RunOf(felt, {});
  json with_needle = felt;
  with_needle["needle"] = {{"model", "bendable"}};
  EXPECT_NE(RunOf(with_needle, {}).needle_force, at_rest.needle_force);
  const json vessels = {{"centrelines", "vessels.csv"}, {"radial_strain", 0.2}, {"reach_mm", 20}};
  moved = images;
  moved["pulsating_vessels"] = vessels;
  EXPECT_NE(RunOf(moved, {}).ct_slice, before.ct_slice);
  EXPECT_NE(RunOf(moved, {}).ultrasound, before.ultrasound);
  json pulsed = felt;
  pulsed["pulsating_vessels"] = vessels;
  EXPECT_NE(RunOf(pulsed, {}).needle_force, at_rest.needle_force);
  EXPECT_NE(RunOf(pulsed, {}).probe_force, at_rest.probe_force);
  moved = images;
  moved["peristalsis"] = {{"centrelines", "vessels.csv"}, {"contraction", 0.4}};
  EXPECT_NE(RunOf(moved, {}).ct_slice, before.ct_slice);
  json jerked = felt;
  jerked["pain_reaction"] = {{"tissues", {"skin", "muscle"}}, {"latency_s", 0.0}};
  EXPECT_NE(RunOf(jerked, {}).needle_force, at_rest.needle_force);
  EXPECT_NE(RunOf(jerked, {}).probe_force, at_rest.probe_force);
  json pressed = felt;
  pressed["fluid"] = {{"thumb", "continuous"}, {"presses_from", "skin"}};
  EXPECT_NE(RunOf(pressed, {}).needle_force, at_rest.needle_force);
  const auto largest = [](const std::vector<double>& values) {
    return *std::ranges::max_element(values, {}, [](double v) { return std::abs(v); });
  };
  EXPECT_NE(largest(at_rest.needle_force), 0.0);
  EXPECT_NE(largest(at_rest.probe_force), 0.0);
}

}  // namespace
}  // namespace acus::simulation
