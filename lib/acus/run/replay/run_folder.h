// What a replay gave, and the folder that it is written into.
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
#include "acus/run/replay/run_metrics.h"
#include "acus/run/replay/step_log.h"
#include "acus/run/training/assessment.h"
#include "acus/scene/simulation/scene.h"

namespace acus::replay {

/// Everything that a run gave, before it is written down.
struct Run {
  session::Session session;
  StepLog steps;
  ImageLog images;
  std::vector<EffectImageLog> effects;
  std::vector<Metric> metrics;
  std::optional<training::Assessment> assessment;  ///< If there is an exercise.
  simulation::StageTimes times;
  std::vector<std::string> warnings;
  std::optional<CostCheck> cost;  ///< If the scenario has evidence.
  std::optional<double> cpu_s;    ///< Of steps and images with their writing, all threads.
};

/// Of the longer stream of tool poses.
double SpanSeconds(const session::Session& session);

/// Writes logs, events, markups, metrics, run.json, provenance.json and report.html. Images are in
/// the folder already. @throws IoError if a file cannot be written.
void WriteRunFolder(const std::filesystem::path& folder, const scenario::Scenario& scenario,
                    const simulation::Scene& scene, const transforms::Landmarks& targets,
                    const Run& run, const RunContext& context);

}  // namespace acus::replay
