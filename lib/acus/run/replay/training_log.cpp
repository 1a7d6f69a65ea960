#include "acus/run/replay/training_log.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/data/transforms/landmarks.h"
#include "acus/run/replay/exercise_watch.h"
#include "acus/run/training/handling_metrics.h"
#include "acus/run/training/session_metrics.h"
#include "acus/scene/simulation/scene.h"

namespace acus::replay {
namespace {

Eigen::Vector3d TargetOf(const training::Exercise& exercise, const std::filesystem::path& file) {
  const transforms::Landmarks points = transforms::ReadLandmarks(file);
  const auto point = std::ranges::find(points.names, exercise.target_point);
  ACUS_REQUIRE(point != points.names.end(), file.string(), ": has no point named \"",
               exercise.target_point, "\", the exercise's target");
  return points.points_mm.col(point - points.names.begin());
}

std::filesystem::path TargetFile(const training::Exercise& exercise,
                                 const scenario::Scenario& scenario) {
  return exercise.target_file.empty() ? scenario.patient.corridor : exercise.target_file;
}

}  // namespace

void RequireAssessable(const training::Exercise& exercise, const scenario::Scenario& scenario,
                       const simulation::Scene& scene, const session::Session* session) {
  ACUS_REQUIRE(scene.labels != nullptr,
               "an exercise needs the tissues: no effect of this scenario reads the label "
               "map; call for needle_force with model layered, or leave --exercise out");
  ACUS_REQUIRE(session == nullptr || !session->needle.empty(),
               "an exercise needs a needle; this session has none");
  const std::filesystem::path target = TargetFile(exercise, scenario);
  if (!target.empty()) TargetOf(exercise, target);
}

void RequireTargetOfGoals(const training::Exercise& exercise, const scenario::Scenario& scenario) {
  if (!TargetFile(exercise, scenario).empty()) return;
  for (const training::Goal& goal : exercise.goals) {
    const bool is_of_target =
        goal.metric.starts_with("tip to target") || goal.metric == training::kTimeToTarget;
    ACUS_REQUIRE(
        !is_of_target, "the exercise has a goal for \"", goal.metric,
        "\", but neither the exercise nor the scenario has a target: give /patient/corridor,"
        " such as corridor_ct.csv of acus-phantom, or the exercise's target/file");
  }
}

std::optional<Eigen::Vector3d> TargetInCtMm(const training::Exercise& exercise,
                                            const scenario::Scenario& scenario) {
  const std::filesystem::path file = TargetFile(exercise, scenario);
  if (file.empty()) return std::nullopt;
  return TargetOf(exercise, file);
}

training::Assessment AssessMotion(const training::Exercise& exercise,
                                  const training::Anatomy& anatomy,
                                  const std::optional<Eigen::Vector3d>& target_ct_mm,
                                  const session::Session& session, std::vector<Metric> metrics) {
  if (target_ct_mm) {
    const auto of_target = training::TargetMetricsOf(session, anatomy, *target_ct_mm, exercise);
    metrics.insert(metrics.end(), of_target.begin(), of_target.end());
  }
  const auto of_hands = training::HandlingMetricsOf(session, anatomy, exercise.passes);
  metrics.insert(metrics.end(), of_hands.begin(), of_hands.end());
  auto structures = training::NamedStructuresOf(session, anatomy);
  metrics.push_back(training::EntriesInto(exercise.avoid, structures));
  auto goals = training::JudgeGoals(exercise.goals, metrics);
  training::Assessment assessment{
      exercise.name, "", session.name, std::move(metrics), std::move(goals), std::move(structures)};
  if (target_ct_mm) assessment.target = exercise.target_name;
  assessment.target_radius_mm = exercise.target_radius_mm;
  return assessment;
}

training::Assessment Assess(const training::Exercise& exercise, const scenario::Scenario& scenario,
                            const simulation::Scene& scene, const session::Session& session,
                            std::vector<Metric> metrics, RunContext& context) {
  RequireAssessable(exercise, scenario, scene, &session);
  const std::filesystem::path target = TargetFile(exercise, scenario);
  if (!target.empty()) context.provenance.AddInput(target);
  for (const std::string& name : training::NotInMap(exercise.avoid, *scene.labels)) {
    context.Warn(
        Message("the patient's label map has no ", name, ": whether it was spared is unknown"));
  }
  const auto target_ct_mm = TargetInCtMm(exercise, scenario);
  training::Assessment assessment = AssessMotion(exercise, {*scene.labels, scene.ct_from_reference},
                                                 target_ct_mm, session, std::move(metrics));
  assessment.checklist = ChecklistOf(exercise, scene, target_ct_mm, session);
  return assessment;
}

}  // namespace acus::replay
