// The steps of a replay: forces and states by sample.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/run_context.h"
#include "session/session.h"
#include "simulation/simulation.h"

namespace acus::replay {

/// Every step of a session, in order of time.
struct StepLog {
  std::vector<simulation::StepOutput> steps;  ///< One per needle sample; empty without a needle.
  simulation::State final_state;
  double cpu_s = 0.0;  ///< Thread CPU time of all steps together.
};

/// Runs Step over all needle samples of a session. Adds the cost of each stage to `times`, if
/// given.
StepLog RunSteps(const simulation::Scene& scene, const session::Session& session,
                 simulation::StageTimes* times, const RunContext& context);

/// Name of a label in the scene's label map.
std::string TissueName(const simulation::Scene& scene, volume::Label label);

/// "bone contact": an event in words.
std::string EventWords(forces::NeedleEvent event);

/// Writes forces.csv: one row per step, columns with units; forces are those on the needle,
/// force_axial_n is + where it pushes the needle out.
void WriteForces(const std::filesystem::path& path, const StepLog& log,
                 const simulation::Scene& scene);

}  // namespace acus::replay
