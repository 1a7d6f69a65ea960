#include "simulation/effect_plan.h"

#include <algorithm>
#include <set>

#include "core/error.h"

namespace acus::simulation {
namespace {

using scenario::Scenario;
using Names = std::vector<std::string_view>;

/// All stages that there are, in the order in which they run.
std::vector<PlannedStage> DeclaredStages(const Scenario& s) {
  const auto with_needle = [](Names reads, bool needle) {
    if (needle) reads.push_back("needle");
    return reads;
  };
  return {
      {StageId::kNeedlePose, "needle pose", "step", {"needle poses"}, {"needle"}, false, ""},
      {StageId::kTissueLookup,
       "tissue lookup",
       "step",
       {"needle", "labels"},
       {"tissue"},
       false,
       ""},
      {StageId::kNeedleForce,
       "needle force",
       "step",
       {"needle", "tissue", "force table"},
       {"force"},
       false,
       ""},
      {StageId::kProbePose, "probe pose", "image", {"probe poses"}, {"probe"}, false, ""},
      {StageId::kCtSlice,
       "CT slice",
       "image",
       with_needle({"probe", "ct"}, s.ct_slice && s.ct_slice->needle),
       {"CT picture"},
       false,
       ""},
      {StageId::kUltrasound,
       "B-mode",
       "image",
       with_needle({"probe", "ct"}, s.ultrasound && s.ultrasound->needle),
       {"B-mode picture"},
       false,
       ""},
  };
}

/// What a stage produces that no other stage reads: it is there for an effect's sake.
struct Goal {
  StageId stage;
  std::string effect;
};

std::vector<Goal> Goals(const Scenario& s) {
  std::vector<Goal> goals;
  if (s.needle_force) goals.push_back({StageId::kNeedleForce, "needle_force"});
  if (s.ct_slice) goals.push_back({StageId::kCtSlice, "ct_slice"});
  if (s.ultrasound) goals.push_back({StageId::kUltrasound, "ultrasound"});
  return goals;
}

/// Inputs from outside and what to do when one is missing.
struct Input {
  std::string_view name;
  bool there;
  const char* remedy;
};

std::vector<Input> Inputs(const Scenario& s, const AvailableInputs& available) {
  return {
      {"needle poses", available.needle_poses, "the session has no needle stream"},
      {"probe poses", available.probe_poses, "the session has no probe stream"},
      {"ct", !s.patient.ct.empty(), "/patient/ct is not given"},
      {"labels", !s.patient.labels.empty(), "/patient/labels is not given"},
      {"force table", true, ""},
  };
}

}  // namespace

bool EffectPlan::Has(StageId id) const {
  return std::ranges::any_of(stages_, [id](const auto& s) { return s.id == id && s.in; });
}

bool EffectPlan::Needs(std::string_view data) const {
  return std::ranges::any_of(stages_, [data](const auto& s) {
    return s.in && std::ranges::find(s.reads, data) != s.reads.end();
  });
}

EffectPlan PlanEffects(const Scenario& scenario, const AvailableInputs& available) {
  EffectPlan plan;
  plan.stages_ = DeclaredStages(scenario);
  auto& stages = plan.stages_;
  for (const Goal& goal : Goals(scenario)) {
    auto& stage = *std::ranges::find(stages, goal.stage, &PlannedStage::id);
    stage.in = true;
    stage.reason = "effect " + goal.effect + " is called for";
  }
  // Backwards: a stage is in if one behind it reads what it writes.
  for (auto reader = stages.rbegin(); reader != stages.rend(); ++reader) {
    if (!reader->in) continue;
    for (auto& writer : stages) {
      const bool feeds =
          std::ranges::find_first_of(writer.writes, reader->reads) != writer.writes.end();
      if (!feeds || writer.in) continue;
      writer.in = true;
      writer.reason = Message("needed by ", reader->name);
    }
  }
  const auto inputs = Inputs(scenario, available);
  std::string missing;
  for (auto& stage : stages) {
    if (!stage.in) stage.reason = "no effect of the scenario needs it";
    if (!stage.in) continue;
    for (const auto& input : inputs) {
      if (input.there || std::ranges::find(stage.reads, input.name) == stage.reads.end()) continue;
      missing += Message("\n  ", stage.name, " (", stage.reason, ") needs ", input.name, ": ",
                         input.remedy);
    }
  }
  ACUS_REQUIRE(missing.empty(), scenario.file.string(), ": effects lack inputs:", missing,
               "\nGive the input, or take the effect out of the scenario (--set "
               "/effects/NAME=null).");
  return plan;
}

}  // namespace acus::simulation
