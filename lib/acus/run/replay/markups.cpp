#include "acus/run/replay/markups.h"

#include <optional>
#include <string>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/run/replay/training_log.h"

namespace acus::replay {

namespace fs = std::filesystem;

transforms::Landmarks TargetsOf(const training::Exercise* exercise,
                                const scenario::Scenario& scenario) {
  transforms::Landmarks points;
  const fs::path& corridor = scenario.patient.corridor;
  if (!corridor.empty() && fs::exists(corridor)) points = transforms::ReadLandmarks(corridor);
  const bool is_elsewhere = exercise != nullptr && !exercise->target_file.empty();
  std::string goal = "target";
  if (exercise != nullptr) goal = is_elsewhere ? exercise->target_name : exercise->target_point;
  std::vector<std::pair<std::string, Eigen::Vector3d>> ordered;
  std::optional<Eigen::Vector3d> goal_mm;
  for (std::size_t i = 0; i < points.names.size(); ++i) {
    const Eigen::Vector3d point_mm = points.points_mm.col(static_cast<Eigen::Index>(i));
    if (points.names[i] == goal) {
      goal_mm = point_mm;
    } else {
      ordered.emplace_back(points.names[i], point_mm);
    }
  }
  if (is_elsewhere) goal_mm = replay::TargetInCtMm(*exercise, scenario);
  if (goal_mm) ordered.emplace_back(goal, *goal_mm);
  transforms::Landmarks targets;
  targets.points_mm.resize(3, static_cast<Eigen::Index>(ordered.size()));
  for (const auto& [name, point_mm] : ordered) {
    targets.points_mm.col(static_cast<Eigen::Index>(targets.names.size())) = point_mm;
    targets.names.push_back(name);
  }
  return targets;
}

void WriteTargets(const fs::path& folder, const transforms::Landmarks& targets) {
  if (!targets.names.empty()) transforms::WriteLandmarks(folder / kTargetMarkups, targets);
}

void WriteEventMarkups(const fs::path& folder, const std::vector<LoggedEvent>& events) {
  if (events.empty()) return;
  transforms::Landmarks points;
  points.points_mm.resize(3, static_cast<Eigen::Index>(events.size()));
  for (const LoggedEvent& event : events) {
    points.points_mm.col(static_cast<Eigen::Index>(points.names.size())) = event.tip_ct_mm;
    points.names.push_back(Message(points.names.size() + 1, " ", event.name, " ", event.tissue));
  }
  transforms::WriteLandmarks(folder / kEventMarkups, points);
}

}  // namespace acus::replay
