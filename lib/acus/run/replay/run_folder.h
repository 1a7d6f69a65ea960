// The results of a replay, and the folder that they are written to.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/session/session.h"
#include "acus/data/transforms/landmarks.h"
#include "acus/run/replay/cost_check.h"
#include "acus/run/replay/effect_image_log.h"
#include "acus/run/replay/image_log.h"
#include "acus/run/replay/patient_range.h"
#include "acus/run/replay/run_metrics.h"
#include "acus/run/replay/step_log.h"
#include "acus/run/training/assessment.h"
#include "acus/scene/simulation/scene.h"

namespace acus::replay {

/// All results of a run, before they are written.
struct Run {
  session::Session session;
  StepLog steps;
  ImageLog images;
  std::vector<EffectImageLog> effects;
  std::vector<Metric> metrics;
  std::optional<training::Assessment> assessment;  ///< If there is an exercise.
  simulation::StageTimes times;
  std::vector<std::string> warnings;
  std::optional<PatientRange> others;  ///< If the scenario has other patients.
  std::optional<CostCheck> cost;       ///< If the scenario has evidence.
  std::optional<double> cpu_s;  ///< CPU time of steps and images with their writing, all threads.
};

/// Duration of the longer stream of tool poses.
double SpanSeconds(const session::Session& session);

/// Writes logs, events, markups, metrics, run.json, provenance.json and report.html. The folder
/// contains the images already. @throws IoError if a file cannot be written.
void WriteRunFolder(const std::filesystem::path& folder, const scenario::Scenario& scenario,
                    const simulation::Scene& scene, const transforms::Landmarks& targets,
                    const Run& run, const RunContext& context);

}  // namespace acus::replay
