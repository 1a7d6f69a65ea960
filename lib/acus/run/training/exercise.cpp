#include "acus/run/training/exercise.h"

#include <numbers>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::training {
namespace {

using nlohmann::json;

std::optional<double> LimitOf(const json& goal, const char* key) {
  if (!goal.contains(key)) return std::nullopt;
  return goal.at(key).get<double>();
}

/// By default, the target decides whether a trial passes.
bool IsMust(const json& goal) {
  if (goal.contains("must")) return goal.at("must");
  return goal.at("metric").get<std::string>().starts_with("tip to target");
}

std::vector<Goal> GoalsOf(const json& list, const std::string& file) {
  std::vector<Goal> goals;
  std::set<std::string> seen;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const json& entry = list[i];
    const std::string where = Message(file, ": /goals/", i, ": ");
    Goal goal{entry.at("metric"), LimitOf(entry, "at_most"), LimitOf(entry, "at_least"),
              entry.at("why"),    entry.at("weight"),        IsMust(entry)};
    ACUS_REQUIRE(goal.at_most || goal.at_least, where,
                 "has no limit; give at_most, at_least or both");
    ACUS_REQUIRE(!goal.at_most || !goal.at_least || *goal.at_least <= *goal.at_most, where,
                 "at_least ", *goal.at_least, " lies above at_most ", *goal.at_most);
    ACUS_REQUIRE(seen.insert(goal.metric).second, where, "\"", goal.metric,
                 "\" has a goal already; give both limits in one");
    goals.push_back(std::move(goal));
  }
  return goals;
}

Checklist ChecklistOf(const json& document) {
  Checklist checklist;
  checklist.in_order = document.at("order") == "fixed";
  for (const json& step : document.at("steps")) {
    checklist.steps.push_back({.text = step.at("text"),
                               // The schema allows no other word.
                               .when = *StepConditionOf(step.at("when").get<std::string>()),
                               .for_s = step.at("for_s"),
                               .hint = step.at("hint")});
  }
  return checklist;
}

}  // namespace

Exercise ReadExercise(const std::filesystem::path& path) {
  const json document = config::ReadConfig(path, "acus-exercise");
  Exercise exercise;
  exercise.name = document.at("name");
  exercise.instructions = document.at("instructions");
  exercise.scenario = document.at("scenario").get<std::string>();
  const json& target = document.at("target");
  const std::string file = target.at("file");
  if (!file.empty()) exercise.target_file = std::filesystem::absolute(path).parent_path() / file;
  exercise.target_point = target.at("point");
  exercise.target_name = target.at("name");
  if (exercise.target_name.empty()) exercise.target_name = exercise.target_point;
  exercise.target_radius_mm = target.at("radius_mm");
  exercise.avoid = document.at("avoid").get<std::vector<std::string>>();
  const json& passes = document.at("passes");
  exercise.passes = {passes.at("turn_mm"),
                     passes.at("redirection_deg").get<double>() * std::numbers::pi / 180.0,
                     passes.at("withdrawal_mm")};
  const json& plane = document.at("image_plane");
  exercise.image_plane = {plane.at("half_thickness_mm"), plane.at("shaft_mm")};
  exercise.goals = GoalsOf(document.at("goals"), path.string());
  exercise.checklist = ChecklistOf(document.at("checklist"));
  const json& hints = document.at("hints");
  exercise.hints = {hints.at("coach"), hints.at("trials"), hints.at("wait_s")};
  return exercise;
}

}  // namespace acus::training
