#include "acus/run/training/assessment.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/data/session/pose_csv.h"

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

/// A number of a file that becomes an integer: the conversion of a larger one is undefined.
double NumberWithin(const std::string& file, const json& object, const char* key, double least,
                    double most) {
  const auto value = object.at(key).get<double>();
  ACUS_REQUIRE(value >= least && value <= most, file, ": ", key, ": is ", object.at(key).dump(),
               "; allowed is ", least, " to ", most, ". Make the file again with acus-replay");
  return value;
}

std::int64_t TimeNsOf(const std::string& file, const json& object, const char* key) {
  return std::llround(1e9 *
                      NumberWithin(file, object, key, -session::kMaxTimeS, session::kMaxTimeS));
}

StructureEntered StructureFrom(const std::string& file, const json& s) {
  constexpr double kMostLabel = std::numeric_limits<volume::Label>::max();
  constexpr double kMostEntries = std::numeric_limits<int>::max();
  return {.label = static_cast<volume::Label>(NumberWithin(file, s, "label", 0.0, kMostLabel)),
          .num_entries = static_cast<int>(NumberWithin(file, s, "entries", 0.0, kMostEntries)),
          .path_mm = s.at("path_mm"),
          .first_ns = TimeNsOf(file, s, "first_time_s")};
}

bool IsOfProbe(const std::string& metric) {
  return metric.find("probe") != std::string::npos;
}

bool Meets(const Goal& goal, double value) {
  return (!goal.at_most || value <= *goal.at_most) && (!goal.at_least || value >= *goal.at_least);
}

}  // namespace

std::size_t Assessment::NumMet() const {
  return static_cast<std::size_t>(std::ranges::count_if(goals, &GoalResult::met));
}

bool Assessment::Passed() const {
  return std::ranges::all_of(goals, [](const GoalResult& r) { return r.met || !r.goal.must; });
}

bool HasInsertion(const std::vector<Metric>& metrics) {
  const auto passes = std::ranges::find(metrics, "passes", &Metric::name);
  return passes == metrics.end() || passes->value > 0.0;
}

bool IsJudged(const Assessment& assessment, const GoalResult& result) {
  return result.value.has_value() || HasInsertion(assessment.metrics);
}

std::string OutcomeText(const Assessment& assessment) {
  if (!HasInsertion(assessment.metrics)) {
    return "No insertion: the needle made no pass in tissue. Its goals are not judged.";
  }
  const auto value = [&](const char* name) -> std::optional<double> {
    const auto metric = std::ranges::find(assessment.metrics, name, &Metric::name);
    if (metric == assessment.metrics.end()) return std::nullopt;
    return metric->value;
  };
  const auto end_mm = value("tip to target at the end");
  const bool judges_target = assessment.goals.empty() ||
                             std::ranges::any_of(assessment.goals, [](const GoalResult& result) {
                               return result.goal.metric.starts_with("tip to target") ||
                                      result.goal.metric == kTimeToTarget;
                             });
  if (!end_mm || assessment.target.empty() || !judges_target) return "Insertion made.";
  const bool reached = *end_mm <= assessment.target_radius_mm;
  std::string text = Message(reached ? "Target reached" : "Target not reached", ": the tip ended ",
                             RoundedText(*end_mm, 3), " mm from ", assessment.target, " (at most ",
                             RoundedText(assessment.target_radius_mm, 3), " mm).");
  if (const auto reached_s = value(kTimeToTarget); reached_s && !reached) {
    text += Message(" It had been there after ", RoundedText(*reached_s, 3), " s.");
  }
  return text;
}

std::vector<GoalResult> JudgeGoals(const std::vector<Goal>& goals,
                                   const std::vector<Metric>& metrics) {
  std::vector<GoalResult> results;
  const bool has_insertion = HasInsertion(metrics);
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
    if (!has_insertion && !IsOfProbe(goal.metric)) {
      results.push_back({goal, metric->unit, std::nullopt, false});
      continue;
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

namespace {

/// "tip to target at the end: 21 mm, required at most 3 mm".
std::string UnmetText(const GoalResult& result) {
  return Message(result.goal.metric, ": ", result.value ? RoundedText(*result.value, 3) : "-",
                 result.unit.empty() ? "" : " ", result.unit, ", required ",
                 GoalText(result.goal, result.unit));
}

}  // namespace

std::string VerdictText(const Assessment& assessment) {
  if (assessment.goals.empty()) return "";
  if (assessment.Passed()) return "Passed.";
  std::string text;
  for (const GoalResult& result : assessment.goals) {
    if (!result.goal.must || result.met) continue;
    text += (text.empty() ? "Failed: " : "; ") + UnmetText(result);
  }
  return text + '.';
}

std::string GoalsText(const Assessment& assessment) {
  const std::string verdict = VerdictText(assessment);
  std::string text =
      Message(OutcomeText(assessment), '\n', verdict, verdict.empty() ? "" : "\n",
              "Goals met: ", assessment.NumMet(), " of ", assessment.goals.size(), "\n");
  for (const GoalResult& result : assessment.goals) {
    if (result.met || !IsJudged(assessment, result)) continue;
    text += Message("  not met: ", UnmetText(result), result.goal.why.empty() ? "" : ": ",
                    result.goal.why, "\n");
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
                     {"weight", result.goal.weight},
                     {"must", result.goal.must},
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
  json checklist = json::array();
  for (const StepResult& step : assessment.checklist) {
    checklist.push_back({{"text", step.text},
                         {"state", NameOf(step.state)},
                         {"time_s", step.state == StepState::kOpen
                                        ? json(nullptr)
                                        : json(1e-9 * static_cast<double>(step.time_ns))}});
  }
  return {{"format", "acus-training/1"},
          {"exercise", assessment.exercise},
          {"trainee", assessment.trainee},
          {"session", assessment.session},
          {"metrics", metrics},
          {"goals", goals},
          {"structures", structures},
          {"outcome", OutcomeText(assessment)},
          {"passed", assessment.Passed()},
          {"target", assessment.target},
          {"target_radius_mm", assessment.target_radius_mm},
          {"checklist", checklist},
          {"by_virtual_trainee", assessment.by_virtual_trainee}};
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
          {{g.at("metric"), NumberFrom(g.at("at_most")), NumberFrom(g.at("at_least")), g.at("why"),
            g.value("weight", 1.0), g.value("must", false)},
           g.at("unit"),
           NumberFrom(g.at("value")),
           g.at("met")});
    }
    for (const json& s : document.at("structures")) {
      assessment.structures.push_back({s.at("name"), StructureFrom(path.string(), s)});
    }
    // Runs of earlier versions lack these.
    assessment.target = document.value("target", "");
    assessment.by_virtual_trainee = document.value("by_virtual_trainee", false);
    assessment.target_radius_mm = document.value("target_radius_mm", 0.0);
    for (const json& step : document.value("checklist", json::array())) {
      StepResult result{.text = step.at("text")};
      if (step.at("state") != "open") {
        result.state = step.at("state") == "done" ? StepState::kDone : StepState::kFailed;
        result.time_ns = TimeNsOf(path.string(), step, "time_s");
      }
      assessment.checklist.push_back(result);
    }
    return assessment;
  } catch (const json::exception& error) {
    throw InputError(
        Message(path.string(), ": is not a training.json of acus-replay: ", error.what()));
  }
}

}  // namespace acus::training
