// The steps of a replay: forces and states by sample.
#pragma once

#include <deque>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/session/session.h"
#include "acus/run/replay/force_rows.h"
#include "acus/scene/simulation/probe_image_renderer.h"
#include "acus/scene/simulation/simulation.h"

namespace acus::replay {

/// The patient's breath at a time, if the session holds it; else breath at rest.
breathing::Breath BreathOf(const session::Session& session, std::int64_t time_ns);

/// Every step of a session, in order of time.
struct StepLog {
  /// An event of the needle during a step.
  struct Passed {
    std::size_t step = 0;
    forces::PassedEvent event;
  };

  std::vector<simulation::StepOutput> steps;  ///< One per needle sample; none without tools.
  std::vector<Passed> passed;                 ///< In order; from models that report events.
  std::deque<tissue::TissueLoad> loads;       ///< Loads of images that show deformed tissue.
  std::deque<math::Polyline> shapes;          ///< Shapes of images that show a bent needle.
  std::deque<effects::Memory> memories;       ///< States for all images, if effects have states.
  math::Polyline most_bent;                   ///< The needle at its largest deflection, if any.
  std::size_t most_bent_step = 0;
  simulation::State final_state;
  double cpu_s = 0.0;  ///< Thread CPU time of all steps together.
};

/// Runs Step over all needle samples of a session, or over the probe's if no stage in the plan
/// reads the needle. Effects of the list run with either. If the plan has a deformation or a needle
/// shape, each image of `images` (ascending times) receives the load and shape after the last step
/// before it, kept in the log. Adds the cost of each stage to `times`, if given. Appends the thread
/// CPU time of each step to `step_cpu_s`, if given.
StepLog RunSteps(const simulation::Scene& scene, const session::Session& session,
                 std::span<simulation::Snapshot> images, simulation::StageTimes* times,
                 const RunContext& context, std::vector<double>* step_cpu_s = nullptr);

/// The step at or before a time; null before the first.
const simulation::StepOutput* StepAt(const StepLog& log, std::int64_t time_ns);

/// "bone contact": the name of an event in words.
std::string EventWords(std::string_view name);

/// Writes forces.csv: one row per step, columns with units; forces are those on the needle,
/// force_axial_n is positive where it pushes the needle out.
void WriteForces(const std::filesystem::path& path, const StepLog& log,
                 const simulation::Scene& scene);

/// Writes KEY.csv for each effect of the list with columns: one row per step.
void WriteListedEffects(const std::filesystem::path& folder, const StepLog& log,
                        const simulation::Scene& scene);

/// Writes probe_forces.csv: one row per step, the force on the probe or the fingertip, CT axes.
void WriteProbeForces(const std::filesystem::path& path, const StepLog& log,
                      const simulation::Scene& scene);

}  // namespace acus::replay
