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

bool Meets(const CurriculumStep& step, const TrialRecord& trial) {
  return trial.passed && PercentOf(trial, kScore) >= step.score_percent &&
         PercentOf(trial, kGoalsMet) >= step.goals_met_percent;
}

/// Trials in order of time: those of one exercise are sorted, and the names of sessions' folders
/// begin with their time.
std::vector<TrialRecord> TrialsOf(const CurriculumStep& step, const std::string& code,
                                  std::span<const TrialRecord> trials) {
  std::vector<TrialRecord> found;
  std::ranges::copy_if(trials, std::back_inserter(found), [&](const TrialRecord& trial) {
    return trial.code == code &&
           std::ranges::find(step.cases, trial.exercise, &Case::exercise) != step.cases.end();
  });
  if (step.cases.size() == 1) return found;
  std::ranges::stable_sort(found, [](const TrialRecord& a, const TrialRecord& b) {
    return NaturallyBefore(a.folder.string(), b.folder.string());
  });
  return found;
}

StepState StateOf(const CurriculumStep& step, const std::string& code,
                  std::span<const TrialRecord> trials) {
  StepState state;
  int row = 0;
  std::vector<CaseTrial> done;
  for (const TrialRecord& trial : TrialsOf(step, code, trials)) {
    ++state.trials;
    state.best_score_percent = std::max(state.best_score_percent, PercentOf(trial, kScore));
    done.push_back({trial.exercise, Meets(step, trial)});
    row = done.back().succeeded ? row + 1 : 0;
    state.longest_row = std::max(state.longest_row, row);
  }
  state.mastered = state.longest_row >= step.in_a_row;
  state.next = NextCase(step.cases, step.order, code, done);
  return state;
}

std::string WordOf(const CurriculumStep& step, const StepState& state) {
  if (state.mastered) return step.RequiresNothing() ? "done" : "mastered";
  return state.open ? "open" : "locked";
}

std::string AllText(const Curriculum& curriculum) {
  return std::ranges::any_of(curriculum.steps, &CurriculumStep::RequiresNothing) ? "all done"
                                                                                 : "all mastered";
}

std::string NextText(const CurriculumStep& step, const StepState& state) {
  if (step.cases.size() == 1) return step.title;
  return Message(step.title, ": ", state.next.exercise, " (difficulty ",
                 FixedText(state.next.difficulty, 2), ")");
}

/// The first step that is open and not mastered.
std::optional<std::size_t> NextStep(std::span<const StepState> states) {
  const auto found = std::ranges::find_if(
      states, [](const StepState& state) { return state.open && !state.mastered; });
  if (found == states.end()) return std::nullopt;
  return static_cast<std::size_t>(found - states.begin());
}

/// Title and cases. @param written  The name of this step for later ones.
CurriculumStep StepWithCases(const json& entry, const fs::path& folder, const std::string& where,
                             std::string& written) {
  ACUS_REQUIRE(entry.contains("exercise") != entry.contains("cases"), where,
               "must have either \"exercise\" or \"cases\"");
  CurriculumStep step;
  if (entry.contains("exercise")) {
    written = entry["exercise"];
    const fs::path file = config::FindConfig(written, folder);
    step.title = training::ReadExercise(file).name;
    step.cases = {{step.title, file, 0.0}};
    return step;
  }
  written = entry["cases"];
  const json& range = entry.at("difficulty");
  ACUS_REQUIRE(range[0] <= range[1], where, "/difficulty: from ", range[0].get<double>(), " to ",
               range[1].get<double>(), "; the smaller one comes first");
  step.cases = ReadCases(folder / written, {range[0], range[1]});
  step.title = entry.value("name", fs::path(written).stem().string());
  if (entry.at("order") == "staircase") step.order = CaseOrder::kStaircase;
  return step;
}

void RequireNew(const Curriculum& curriculum, const CurriculumStep& step,
                const std::string& where) {
  for (const CurriculumStep& other : curriculum.steps) {
    ACUS_REQUIRE(other.title != step.title, where, "another step is named \"", step.title,
                 "\", too");
    for (const Case& one : step.cases) {
      ACUS_REQUIRE(
          std::ranges::find(other.cases, one.exercise, &Case::exercise) == other.cases.end(), where,
          "the exercise \"", one.exercise, "\" is there twice");
    }
  }
}

}  // namespace

Curriculum ReadCurriculum(const fs::path& path) {
  const json file = config::ReadConfig(path, "acus-curriculum");
  const fs::path folder = fs::absolute(path).parent_path();
  Curriculum curriculum{file.at("name"), {}};
  std::vector<std::string> written;
  for (const json& entry : file.at("steps")) {
    const std::string where = Message(path.string(), ": /steps/", written.size(), ": ");
    std::string name;
    CurriculumStep step = StepWithCases(entry, folder, where, name);
    const json& mastery = entry.at("mastery");
    step.score_percent = mastery.at("score_percent");
    step.goals_met_percent = mastery.at("goals_met_percent");
    step.in_a_row = mastery.at("in_a_row");
    if (entry.contains("time_limit_s")) step.time_limit_s = entry["time_limit_s"].get<double>();
    RequireNew(curriculum, step, where);
    for (const std::string before : entry.at("after")) {
      const auto found = std::ranges::find(written, before);
      ACUS_REQUIRE(found != written.end(), where, "/after: \"", before,
                   "\" is not the exercise of an earlier step");
      step.after.push_back(static_cast<std::size_t>(found - written.begin()));
    }
    curriculum.steps.push_back(std::move(step));
    written.push_back(name);
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
      rows.push_back({curriculum.steps[n].title, WordOf(curriculum.steps[n], states[n]),
                      std::to_string(states[n].trials),
                      states[n].trials > 0 ? FixedText(states[n].best_score_percent, 0) : "-",
                      Message(states[n].longest_row, " of ", curriculum.steps[n].in_a_row)});
    }
    text += Message(
        "\n", code.empty() ? "-" : code, ": ",
        next ? "next: " + NextText(curriculum.steps[*next], states[*next]) : AllText(curriculum),
        "\n", TextTable({"exercise", "state", "trials", "best score [%]", "in a row"}, rows));
  }
  return text;
}

json CurriculumJson(const Curriculum& curriculum, std::span<const TrialRecord> trials,
                    const std::set<std::string>& codes) {
  json steps = json::array();
  for (const CurriculumStep& step : curriculum.steps) {
    steps.push_back(
        {{"exercise", step.title},
         {"cases", step.cases.size()},
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
    for (std::size_t n = 0; n < states.size(); ++n) {
      const StepState& state = states[n];
      list.push_back({{"state", WordOf(curriculum.steps[n], state)},
                      {"trials", state.trials},
                      {"best_score_percent", state.best_score_percent},
                      {"longest_row", state.longest_row},
                      {"next_case",
                       {{"exercise", state.next.exercise},
                        {"file", state.next.file.string()},
                        {"difficulty", state.next.difficulty}}}});
    }
    trainees[code] = {{"next", next ? json(*next) : json(nullptr)}, {"steps", std::move(list)}};
  }
  return {{"format", "acus-curriculum-state/1"},
          {"name", curriculum.name},
          {"steps", std::move(steps)},
          {"trainees", std::move(trainees)}};
}

}  // namespace acus::study
