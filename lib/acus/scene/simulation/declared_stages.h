// The inputs and outputs of every stage in a scenario, before the plan selects stages.
#pragma once

#include "acus/scene/simulation/effect_plan.h"

namespace acus::simulation {

/// A stage that is in the plan for the sake of an effect.
struct Goal {
  std::size_t stage;        ///< Its number.
  std::string_view effect;  ///< Its key in the scenario.
};

/// All stages, none of them in the plan yet, and those that the scenario's effects need.
struct DeclaredStages {
  DeclaredStages(const scenario::Scenario& scenario, bool breath_from_session);

  std::vector<PlannedStage> stages;  ///< In the order in which they run.
  std::vector<Goal> goals;           ///< In the plan even if no other stage reads what they write.
  /// Stages through which effects act, where another effect's stage reads their output.
  std::vector<Goal> helpers;
};

/// An input from outside that stages may read.
struct DeclaredInput {
  PlannedInput input;
  std::string missing;  ///< The problem and its remedy if it is not given; empty if it is.
};
std::vector<DeclaredInput> DeclaredInputs(const scenario::Scenario& scenario,
                                          const AvailableInputs& available);

}  // namespace acus::simulation
