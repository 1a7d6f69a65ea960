#include "acus/assess/study/curriculum.h"

#include <algorithm>
#include <optional>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/run/training/exercise.h"

namespace acus::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

double PercentOf(const TrialRecord& trial, const char* name) {
  const auto found = trial.metrics.find({name, "%"});
  return found == trial.metrics.end() ? 0.0 : found->second;
}

StepState StateOf(const CurriculumStep& step, const std::string& code,
                  std::span<const TrialRecord> trials) {
  StepState state;
  int row = 0;
  for (const TrialRecord& trial : trials) {
    if (trial.code != code || trial.exercise != step.exercise) continue;
    ++state.trials;
    const double score = PercentOf(trial, kScore);
    state.best_score_percent = std::max(state.best_score_percent, score);
    const bool meets =
        score >= step.score_percent && PercentOf(trial, kGoalsMet) >= step.goals_met_percent;
    row = meets ? row + 1 : 0;
    state.longest_row = std::max(state.longest_row, row);
  }
  state.mastered = state.longest_row >= step.in_a_row;
  return state;
}

std::string WordOf(const StepState& state) {
  if (state.mastered) return "mastered";
  return state.open ? "open" : "locked";
}

/// The first that is open and not mastered.
std::optional<std::size_t> NextStep(std::span<const StepState> states) {
  const auto found = std::ranges::find_if(
      states, [](const StepState& state) { return state.open && !state.mastered; });
  if (found == states.end()) return std::nullopt;
  return static_cast<std::size_t>(found - states.begin());
}

}  // namespace

Curriculum ReadCurriculum(const fs::path& path) {
  const json file = config::ReadConfig(path, "acus-curriculum");
  const fs::path folder = fs::absolute(path).parent_path();
  Curriculum curriculum{file.at("name"), {}};
  std::vector<std::string> written;
  for (const json& entry : file.at("steps")) {
    const std::string where = Message(path.string(), ": /steps/", written.size(), ": ");
    const std::string exercise = entry.at("exercise");
    const json& mastery = entry.at("mastery");
    const fs::path place = config::FindConfig(exercise, folder);
    CurriculumStep step{training::ReadExercise(place).name,
                        place,
                        {},
                        mastery.at("score_percent"),
                        mastery.at("goals_met_percent"),
                        mastery.at("in_a_row"),
                        std::nullopt};
    if (entry.contains("time_limit_s")) step.time_limit_s = entry["time_limit_s"].get<double>();
    ACUS_REQUIRE(std::ranges::find(curriculum.steps, step.exercise, &CurriculumStep::exercise) ==
                     curriculum.steps.end(),
                 where, "the exercise \"", step.exercise, "\" is there twice");
    for (const std::string before : entry.at("after")) {
      const auto found = std::ranges::find(written, before);
      ACUS_REQUIRE(found != written.end(), where, "/after: \"", before,
                   "\" is not the exercise of an earlier step");
      step.after.push_back(static_cast<std::size_t>(found - written.begin()));
    }
    curriculum.steps.push_back(std::move(step));
    written.push_back(exercise);
  }
  return curriculum;
}

std::vector<StepState> ProgressOf(const Curriculum& curriculum, const std::string& code,
                                  std::span<const TrialRecord> trials) {
  std::vector<StepState> states;
  for (const CurriculumStep& step : curriculum.steps) {
    StepState state = StateOf(step, code, trials);
    state.open = std::ranges::all_of(step.after, [&](std::size_t n) { return states[n].mastered; });
    states.push_back(state);
  }
  return states;
}

std::string CurriculumText(const Curriculum& curriculum, std::span<const TrialRecord> trials,
                           const std::set<std::string>& codes) {
  std::string text = curriculum.name + "\n";
  for (const std::string& code : codes) {
    const auto states = ProgressOf(curriculum, code, trials);
    const auto next = NextStep(states);
    std::vector<std::vector<std::string>> rows;
    for (std::size_t n = 0; n < states.size(); ++n) {
      rows.push_back({curriculum.steps[n].exercise, WordOf(states[n]),
                      std::to_string(states[n].trials),
                      states[n].trials > 0 ? FixedText(states[n].best_score_percent, 0) : "-",
                      Message(states[n].longest_row, " of ", curriculum.steps[n].in_a_row)});
    }
    text += Message("\n", code.empty() ? "-" : code, ": ",
                    next ? "next: " + curriculum.steps[*next].exercise : "all mastered", "\n",
                    TextTable({"exercise", "state", "trials", "best score [%]", "in a row"}, rows));
  }
  return text;
}

json CurriculumJson(const Curriculum& curriculum, std::span<const TrialRecord> trials,
                    const std::set<std::string>& codes) {
  json steps = json::array();
  for (const CurriculumStep& step : curriculum.steps) {
    steps.push_back(
        {{"exercise", step.exercise},
         {"file", step.file.string()},
         {"after", step.after},
         {"score_percent", step.score_percent},
         {"goals_met_percent", step.goals_met_percent},
         {"in_a_row", step.in_a_row},
         {"time_limit_s", step.time_limit_s ? json(*step.time_limit_s) : json(nullptr)}});
  }
  json trainees = json::object();
  for (const std::string& code : codes) {
    const auto states = ProgressOf(curriculum, code, trials);
    const auto next = NextStep(states);
    json list = json::array();
    for (const StepState& state : states) {
      list.push_back({{"state", WordOf(state)},
                      {"trials", state.trials},
                      {"best_score_percent", state.best_score_percent},
                      {"longest_row", state.longest_row}});
    }
    trainees[code] = {{"next", next ? json(*next) : json(nullptr)}, {"steps", std::move(list)}};
  }
  return {{"format", "acus-curriculum-state/1"},
          {"name", curriculum.name},
          {"steps", std::move(steps)},
          {"trainees", std::move(trainees)}};
}

}  // namespace acus::study
