#include "acus/scene/simulation/effect_plan.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/scene/simulation/declared_stages.h"

namespace acus::simulation {
namespace {

using scenario::Scenario;
using Stages = std::vector<PlannedStage>;

void WorkFor(PlannedStage& stage, std::string_view effect) {
  if (std::ranges::find(stage.effects, effect) == stage.effects.end()) {
    stage.effects.push_back(effect);
  }
}

/// Backwards: a stage is in the plan if a later one reads its output.
void PickStages(const DeclaredStages& declared, Stages& stages) {
  for (const Goal& goal : declared.goals) {
    PlannedStage& stage = stages[goal.stage];
    stage.in = true;
    stage.reason = Message("effect ", goal.effect, " is called for");
    WorkFor(stage, goal.effect);
  }
  for (auto reader = stages.rbegin(); reader != stages.rend(); ++reader) {
    if (!reader->in) continue;
    for (PlannedStage& writer : stages) {
      if (std::ranges::find_first_of(writer.writes, reader->reads) == writer.writes.end()) continue;
      for (const std::string_view effect : reader->effects) WorkFor(writer, effect);
      if (writer.in) continue;
      writer.in = true;
      writer.reason = Message("needed by ", reader->name);
    }
  }
  for (PlannedStage& stage : stages) {
    if (!stage.in) stage.reason = "no effect of the scenario needs it";
  }
  for (const Goal& helper : declared.helpers) {
    PlannedStage& stage = stages[helper.stage];
    if (stage.in) {
      WorkFor(stage, helper.effect);
    } else {
      stage.reason = Message("effect ", helper.effect, " is called for, but none that it changes");
    }
  }
}

/// "\n  tissue lookup (needed by needle force) needs labels: ..., for effects/needle_force"
std::string Lack(const PlannedStage& stage, std::string_view input, std::string_view why) {
  std::string text =
      Message("\n  ", stage.name, " (", stage.reason, ") needs ", input, ": ", why, "; for ");
  for (const std::string_view effect : stage.effects) {
    text += Message(effect == stage.effects.front() ? "effects/" : ", effects/", effect);
  }
  return text;
}

void RequireNothing(const std::string& lacks, const Scenario& scenario) {
  ACUS_REQUIRE(lacks.empty(), scenario.file.string(), ": effects lack inputs:", lacks,
               "\nGive the input, or take the effect out of the scenario (--set "
               "/effects/NAME=null).");
}

}  // namespace

const PlannedStage& EffectPlan::WriterOf(effects::PortRef port) const {
  const auto writer = std::ranges::find_if(
      stages_, [port](const PlannedStage& stage) { return stage.Writes(port); });
  ACUS_ASSERT(writer != stages_.end());
  return *writer;
}

bool EffectPlan::Writes(effects::PortRef port) const {
  return std::ranges::any_of(
      stages_, [port](const PlannedStage& stage) { return stage.in && stage.Writes(port); });
}

bool EffectPlan::Reads(effects::PortRef written, effects::PortRef data) const {
  return std::ranges::any_of(stages_, [written, data](const PlannedStage& stage) {
    return stage.in && stage.Writes(written) && stage.Reads(data);
  });
}

bool EffectPlan::StepReads(effects::PortRef data) const {
  return std::ranges::any_of(stages_, [data](const PlannedStage& stage) {
    return stage.in && !stage.is_image() && stage.Reads(data);
  });
}

bool EffectPlan::Needs(effects::PortRef data) const {
  return std::ranges::any_of(stages_,
                             [data](const auto& stage) { return stage.in && stage.Reads(data); });
}

EffectPlan PlanEffects(const Scenario& scenario, const AvailableInputs& available) {
  EffectPlan plan;
  plan.breath_from_session_ = scenario.breathing && available.breath &&
                              scenario.breathing->from_session != scenario::SessionBreath::kNever;
  const DeclaredStages declared(scenario, plan.breath_from_session_);
  plan.stages_ = declared.stages;
  PickStages(declared, plan.stages_);
  const auto inputs = DeclaredInputs(scenario, available);
  std::string lacks;
  for (const PlannedStage& stage : plan.stages_) {
    if (!stage.in) continue;
    for (const auto& [input, missing] : inputs) {
      if (!missing.empty() && stage.Reads(input.port)) {
        lacks += Lack(stage, input.port.name(), missing);
      }
    }
  }
  RequireNothing(lacks, scenario);
  for (const auto& [input, missing] : inputs) {
    if (plan.Needs(input.port)) plan.inputs_.push_back(input);
  }
  return plan;
}

void RequireFiles(const EffectPlan& plan, const Scenario& scenario) {
  std::string lacks;
  for (const PlannedInput& input : plan.inputs()) {
    if (input.file.empty() || std::filesystem::exists(input.file)) continue;
    for (const PlannedStage& stage : plan.stages()) {
      if (!stage.in || !stage.Reads(input.port)) continue;
      lacks += Lack(stage, input.port.name(),
                    Message(input.where, ": ", input.file.string(),
                            ": no such file or folder; paths are relative to the scenario file"));
    }
  }
  RequireNothing(lacks, scenario);
}

}  // namespace acus::simulation
