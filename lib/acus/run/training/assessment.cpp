#include "acus/run/training/assessment.h"

#include <algorithm>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"

namespace acus::training {
namespace {

using nlohmann::json;

json NumberOrNull(const std::optional<double>& value) {
  return value ? json(*value) : json(nullptr);
}

std::optional<double> NumberFrom(const json& value) {
  if (value.is_null()) return std::nullopt;
  return value.get<double>();
}

bool Meets(const Goal& goal, double value) {
  return (!goal.at_most || value <= *goal.at_most) && (!goal.at_least || value >= *goal.at_least);
}

}  // namespace

std::size_t Assessment::NumMet() const {
  return static_cast<std::size_t>(std::ranges::count_if(goals, &GoalResult::met));
}

std::vector<GoalResult> JudgeGoals(const std::vector<Goal>& goals,
                                   const std::vector<Metric>& metrics) {
  std::vector<GoalResult> results;
  for (const Goal& goal : goals) {
    const auto metric = std::ranges::find(metrics, goal.metric, &Metric::name);
    const bool has_target = std::ranges::any_of(
        metrics, [](const Metric& m) { return m.name == "tip to target, closest"; });
    if (metric == metrics.end() && goal.metric == kTimeToTarget && has_target) {
      results.push_back({goal, "s", std::nullopt, false});
      continue;
    }
    if (metric == metrics.end()) {
      std::string known;
      for (const Metric& m : metrics) known += (known.empty() ? "" : ", ") + m.name;
      throw InputError(
          Message("the exercise has a goal for \"", goal.metric,
                  "\", which this session and scenario do not give; they give: ", known));
    }
    results.push_back({goal, metric->unit, metric->value, Meets(goal, metric->value)});
  }
  return results;
}

std::string GoalText(const Goal& goal, const std::string& unit) {
  std::string text;
  const auto add = [&](const char* words, const std::optional<double>& limit) {
    if (!limit) return;
    text += Message(text.empty() ? "" : ", ", words, " ", RoundedText(*limit, 4),
                    unit.empty() ? "" : " ", unit);
  };
  add("at least", goal.at_least);
  add("at most", goal.at_most);
  return text;
}

std::string GoalsText(const Assessment& assessment) {
  std::string text =
      Message("Goals met: ", assessment.NumMet(), " of ", assessment.goals.size(), "\n");
  for (const GoalResult& result : assessment.goals) {
    if (result.met) continue;
    text +=
        Message("  not met: ", result.goal.metric, ": ",
                result.value ? RoundedText(*result.value, 3) : "-", result.unit.empty() ? "" : " ",
                result.unit, ", asked for ", GoalText(result.goal, result.unit),
                result.goal.why.empty() ? "" : ": ", result.goal.why, "\n");
  }
  return text;
}

json ToJson(const Assessment& assessment) {
  json metrics = json::array();
  for (const Metric& m : assessment.metrics) {
    metrics.push_back({{"name", m.name}, {"unit", m.unit}, {"value", m.value}});
  }
  json goals = json::array();
  for (const GoalResult& result : assessment.goals) {
    goals.push_back({{"metric", result.goal.metric},
                     {"unit", result.unit},
                     {"value", NumberOrNull(result.value)},
                     {"at_most", NumberOrNull(result.goal.at_most)},
                     {"at_least", NumberOrNull(result.goal.at_least)},
                     {"why", result.goal.why},
                     {"met", result.met}});
  }
  json structures = json::array();
  for (const NamedStructure& s : assessment.structures) {
    structures.push_back({{"name", s.name},
                          {"label", s.entered.label},
                          {"entries", s.entered.num_entries},
                          {"path_mm", s.entered.path_mm},
                          {"first_time_s", 1e-9 * static_cast<double>(s.entered.first_ns)}});
  }
  return {{"format", "acus-training/1"},
          {"exercise", assessment.exercise},
          {"trainee", assessment.trainee},
          {"session", assessment.session},
          {"metrics", metrics},
          {"goals", goals},
          {"structures", structures}};
}

Assessment ReadAssessment(const std::filesystem::path& path) {
  const json document = config::ReadJson(path);
  try {
    ACUS_REQUIRE(document.at("format") == "acus-training/1", path.string(), ": /format: is ",
                 document.at("format").dump(), ", not \"acus-training/1\"");
    Assessment assessment;
    assessment.exercise = document.at("exercise");
    assessment.trainee = document.at("trainee");
    assessment.session = document.at("session");
    for (const json& m : document.at("metrics")) {
      assessment.metrics.push_back({m.at("name"), m.at("unit"), m.at("value")});
    }
    for (const json& g : document.at("goals")) {
      assessment.goals.push_back(
          {{g.at("metric"), NumberFrom(g.at("at_most")), NumberFrom(g.at("at_least")), g.at("why")},
           g.at("unit"),
           NumberFrom(g.at("value")),
           g.at("met")});
    }
    for (const json& s : document.at("structures")) {
      assessment.structures.push_back(
          {s.at("name"),
           {s.at("label"), s.at("entries"), s.at("path_mm"),
            static_cast<std::int64_t>(1e9 * s.at("first_time_s").get<double>())}});
    }
    return assessment;
  } catch (const json::exception& error) {
    throw InputError(
        Message(path.string(), ": is not a training.json of acus-replay: ", error.what()));
  }
}

}  // namespace acus::training
