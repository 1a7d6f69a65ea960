// A patient and an exercise, loaded once for the steps of many sessions, without images.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>

#include "acus/base/core/run_context.h"
#include "acus/data/session/session.h"
#include "acus/run/replay/event_log.h"
#include "acus/run/replay/step_log.h"
#include "acus/run/training/assessment.h"
#include "acus/run/training/session_metrics.h"
#include "acus/scene/scenario/scenario.h"
#include "acus/scene/simulation/scene.h"

namespace acus::trials {

/// Immutable after LoadTrialScene; shared by any number of threads.
struct TrialScene {
  scenario::Scenario scenario;
  simulation::Scene scene;
  training::Exercise exercise;
  std::optional<Eigen::Vector3d> target_ct_mm;  ///< None: the exercise has no target.

  training::Anatomy anatomy() const { return {*scene.labels, scene.ct_from_reference}; }
  /// True if a point in CT space (mm) lies in the body, in the label map at rest.
  bool IsInBody(const Eigen::Vector3d& point_ct_mm) const;
};

/// Loads the data for the steps and the metrics of such sessions; images are not rendered, and
/// their data are read only if no other effect reads the label map.
/// @param like  A session with the streams that the others will have.
/// @throws InputError as replay::ReplaySession does before its first step.
TrialScene LoadTrialScene(const scenario::Scenario& scenario, const std::filesystem::path& exercise,
                          const session::Session& like, RunContext& context);

/// The results of a session without images: the bits that replay::ReplaySession computes.
struct TrialResult {
  training::Assessment assessment;
  std::vector<replay::LoggedEvent> events;  ///< Events of the needle, in order of time.
  std::uint64_t force_hash = 0;             ///< Hash of all forces, see ForceHash.
  double step_cpu_s = 0.0;                  ///< Thread CPU time of the steps.
};

/// FNV-1a, 64 bits, over the bits of time, force and depth of every step.
std::uint64_t ForceHash(const replay::StepLog& steps);

/// Steps and assesses a session. Thread-safe; `context` is only read for a requested stop.
/// @throws InputError if a goal's metric does not exist.
TrialResult RunTrial(const TrialScene& scene, const session::Session& session,
                     const RunContext& context);

}  // namespace acus::trials
