// Assesses a replayed session by an exercise.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <vector>

#include "acus/run/replay/run_metrics.h"
#include "acus/run/training/assessment.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::replay {

/// Checks the conditions of Assess that do not depend on the session's motion.
/// @param session  May be null: any session with a needle.
/// @throws InputError if the scene has no label map or the session no needle, or the target's file
///     is missing or has no such point.
void RequireAssessable(const training::Exercise& exercise, const scenario::Scenario& scenario,
                       const simulation::Scene& scene, const session::Session* session);

/// Rejects a goal of the target where neither the exercise nor the scenario has a target: the
/// assessment would fail after the whole run.
/// @throws InputError naming the goal and what to add.
void RequireTargetOfGoals(const training::Exercise& exercise, const scenario::Scenario& scenario);

/// The target of the tip, in CT space: from the exercise's own file, else from the scenario's
/// corridor; nothing if there is neither.
/// @throws InputError if the file is missing or has no such point.
std::optional<Eigen::Vector3d> TargetInCtMm(const training::Exercise& exercise,
                                            const scenario::Scenario& scenario);

/// Computes the metrics of the target, of the hands and of the structures to spare, in addition to
/// those of the run, and compares them with the exercise's goals. Reads no file and prints no
/// warning: for many sessions in one patient.
/// @throws InputError if a goal's metric does not exist.
training::Assessment AssessMotion(const training::Exercise& exercise,
                                  const training::Anatomy& anatomy,
                                  const std::optional<Eigen::Vector3d>& target_ct_mm,
                                  const session::Session& session, std::vector<Metric> metrics);

/// As AssessMotion, with a warning for structures that the patient's map does not distinguish.
/// @param metrics  As MetricsOf gives them.
/// @throws InputError if the scene has no label map or the session no needle, the target's file is
///     missing or has no such point, or a goal's metric does not exist.
training::Assessment Assess(const training::Exercise& exercise, const scenario::Scenario& scenario,
                            const simulation::Scene& scene, const session::Session& session,
                            std::vector<Metric> metrics, RunContext& context);

}  // namespace acus::replay
