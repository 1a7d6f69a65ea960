// What every stage reads and writes in a scenario, before any of them is picked.
#pragma once

#include "acus/scene/simulation/effect_plan.h"

namespace acus::simulation {

/// A stage that is there for the sake of an effect.
struct Goal {
  std::size_t stage;        ///< Its number.
  std::string_view effect;  ///< Its key in the scenario.
};

/// All stages that there are, none of them in, and which of them the scenario's effects are for.
struct DeclaredStages {
  DeclaredStages(const scenario::Scenario& scenario, bool breath_from_session);

  std::vector<PlannedStage> stages;  ///< In the order in which they run.
  std::vector<Goal> goals;           ///< In the plan even if no other stage reads what they write.
  /// Stages that effects work through, where another effect's stage reads what they write.
  std::vector<Goal> helpers;
};

/// An input from outside that stages may read.
struct DeclaredInput {
  PlannedInput input;
  std::string missing;  ///< What is wrong and what to do if it is not given; empty if it is.
};
std::vector<DeclaredInput> DeclaredInputs(const scenario::Scenario& scenario,
                                          const AvailableInputs& available);

}  // namespace acus::simulation
