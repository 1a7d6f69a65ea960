// What every stage reads and writes in a scenario, before any of them is picked.
#pragma once

#include "acus/scene/simulation/effect_plan.h"

namespace acus::simulation {

/// All stages that there are, in the order in which they run, none of them in.
std::vector<PlannedStage> DeclaredStages(const scenario::Scenario& scenario,
                                         bool breath_from_session);

/// A stage that is there for the sake of an effect, not because another stage needs it.
struct Goal {
  StageId stage;
  std::string_view effect;  ///< Its key in the scenario.
};
std::vector<Goal> GoalsOf(const scenario::Scenario& scenario);

/// Stages that effects work through, where another effect's stage reads what they write.
std::vector<Goal> HelpersOf(const scenario::Scenario& scenario);

/// An input from outside that stages may read.
struct DeclaredInput {
  PlannedInput input;
  std::string missing;  ///< What is wrong and what to do if it is not given; empty if it is.
};
std::vector<DeclaredInput> DeclaredInputs(const scenario::Scenario& scenario,
                                          const AvailableInputs& available);

}  // namespace acus::simulation
