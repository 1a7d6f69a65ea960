// A replayed session held against an exercise.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <vector>

#include "acus/run/replay/run_metrics.h"
#include "acus/run/training/assessment.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::replay {

/// Refuses what Assess would refuse before it looks at the session's motion.
/// @param session  May be null: any session with a needle.
/// @throws InputError if the scene has no label map or the session no needle, or the target's file
///     is missing or has no such point.
void RequireAssessable(const training::Exercise& exercise, const scenario::Scenario& scenario,
                       const simulation::Scene& scene, const session::Session* session);

/// Refuses a goal of the target where neither the exercise nor the scenario has one: the assessment
/// would refuse it after the whole run.
/// @throws InputError naming the goal and what to give.
void RequireTargetOfGoals(const training::Exercise& exercise, const scenario::Scenario& scenario);

/// Where the tip is to go, in CT space: of the exercise's own file, else of the scenario's
/// corridor; nothing if there is neither.
/// @throws InputError if the file is missing or has no such point.
std::optional<Eigen::Vector3d> TargetInCtMm(const training::Exercise& exercise,
                                            const scenario::Scenario& scenario);

/// Metrics of the target, of the hands and of what is to be spared, after those of the run, held
/// against the exercise's goals. Reads no file and warns of nothing: for many sessions in one
/// patient.
/// @throws InputError if a goal's metric is not there.
training::Assessment AssessMotion(const training::Exercise& exercise,
                                  const training::Anatomy& anatomy,
                                  const std::optional<Eigen::Vector3d>& target_ct_mm,
                                  const session::Session& session, std::vector<Metric> metrics);

/// Metrics of the target, of the hands and of what is to be spared, after those of the run, held
/// against the exercise's goals. Warns of structures that the patient's map does not tell apart.
/// @param metrics  As MetricsOf gives them.
/// @throws InputError if the scene has no label map or the session no needle, the target's file is
///     missing or has no such point, or a goal's metric is not there.
training::Assessment Assess(const training::Exercise& exercise, const scenario::Scenario& scenario,
                            const simulation::Scene& scene, const session::Session& session,
                            std::vector<Metric> metrics, RunContext& context);

}  // namespace acus::replay
