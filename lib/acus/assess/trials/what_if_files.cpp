#include "acus/assess/trials/what_if_files.h"

#include <algorithm>
#include <cstdio>
#include <sstream>

#include "acus/assess/trials/skin_map.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/counted.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/angles.h"
#include "acus/base/report/html_report.h"
#include "acus/data/session/session_io.h"

namespace acus::trials {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string HashText(std::uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

/// Names of structures may contain characters that a cell of CSV may not.
std::string CellOf(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c == ',' || c == '\n' || c == '\r'; }, ';');
  return text;
}

std::string NumberOrNothing(const std::optional<double>& value) {
  return value ? NumberText(*value) : "";
}

std::string GoalColumn(const training::GoalResult& goal) {
  return CellOf(goal.goal.metric) + (goal.unit.empty() ? "" : " [" + goal.unit + "]");
}

std::string Table(const WhatIf& what_if) {
  std::vector<std::size_t> rank(what_if.outcomes.size());
  for (std::size_t n = 0; n < rank.size(); ++n) rank[what_if.ranking[n]] = n + 1;
  std::ostringstream csv;
  csv << "number,rank,score,goals_met,aimed,along_mm,across_mm,steeper_deg,sideways_deg,"
         "deeper_mm,speed_factor,breath_cycles,entry_x_mm,entry_y_mm,entry_z_mm,axis_x,axis_y,"
         "axis_z,depth_mm,speed_mm_per_s,force_hash";
  for (const auto& goal : what_if.trial.goals) csv << ',' << GoalColumn(goal);
  csv << '\n';
  for (std::size_t n = 0; n < what_if.outcomes.size(); ++n) {
    const Outcome& outcome = what_if.outcomes[n];
    const Alternative& a = outcome.alternative;
    csv << n << ',' << rank[n] << ',' << NumberText(outcome.score) << ','
        << outcome.result.assessment.NumMet() << ',' << (a.aimed ? 1 : 0);
    for (const double value :
         {a.change.along_mm, a.change.across_mm, a.change.steeper_rad / math::kRadPerDegree,
          a.change.sideways_rad / math::kRadPerDegree, a.change.depth_mm, a.change.speed_factor,
          a.change.breath_cycles, a.entry_ct_mm.x(), a.entry_ct_mm.y(), a.entry_ct_mm.z(),
          a.axis_in_ct.x(), a.axis_in_ct.y(), a.axis_in_ct.z(), a.depth_mm, a.speed_mm_per_s}) {
      csv << ',' << NumberText(value);
    }
    csv << ',' << HashText(outcome.result.force_hash);
    for (const auto& goal : outcome.result.assessment.goals) {
      csv << ',' << NumberOrNothing(goal.value);
    }
    csv << '\n';
  }
  return csv.str();
}

json Row(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

json OutcomeJson(const TrialScene& scene, const WhatIf& what_if, std::size_t number) {
  const Outcome& outcome = what_if.outcomes[number];
  return {{"number", number},
          {"change", ChangeText(what_if.line, outcome.alternative.change)},
          {"outcome", OutcomeText(what_if, outcome, scene.exercise.avoid)},
          {"score", outcome.score},
          {"force_hash", HashText(outcome.result.force_hash)},
          {"entry_ct_mm", Row(outcome.alternative.entry_ct_mm)},
          {"axis_in_ct", Row(outcome.alternative.axis_in_ct)},
          {"assessment", training::ToJson(outcome.result.assessment)}};
}

std::size_t NumBest(const WhatIf& what_if, int best) {
  return std::min(what_if.ranking.size(), static_cast<std::size_t>(best));
}

json Summary(const TrialScene& scene, const WhatIf& what_if, const WhatIfSettings& settings,
             const RunContext& context) {
  json best = json::array();
  for (std::size_t n = 0; n < NumBest(what_if, settings.best); ++n) {
    best.push_back(OutcomeJson(scene, what_if, what_if.ranking[n]));
  }
  return {{"format", "acus-what-if-result/1"},
          {"exercise", scene.exercise.name},
          {"seed", context.seed},
          {"count", what_if.outcomes.size()},
          {"line",
           {{"entry_ct_mm", Row(what_if.line.entry_ct_mm)},
            {"axis_in_ct", Row(what_if.line.axis_in_ct)},
            {"inward_in_ct", Row(what_if.line.inward_in_ct)},
            {"along_in_ct", Row(what_if.line.along_in_ct)},
            {"across_in_ct", Row(what_if.line.across_in_ct)},
            {"depth_mm", what_if.line.depth_mm},
            {"speed_mm_per_s", what_if.line.speed_mm_per_s}}},
          {"trial", training::ToJson(what_if.trial)},
          {"trial_score", what_if.trial_score},
          {"trial_line", OutcomeJson(scene, what_if, 0)},
          {"best", best}};
}

std::vector<std::string> GoalHeader(const WhatIf& what_if) {
  std::vector<std::string> header = {"insertion", "score"};
  for (const auto& goal : what_if.trial.goals) header.push_back(GoalColumn(goal));
  return header;
}

std::vector<std::string> GoalRow(const std::string& name, double score,
                                 const training::Assessment& assessment) {
  std::vector<std::string> row = {name, FixedText(score, 3)};
  for (const auto& goal : assessment.goals) {
    row.push_back((goal.value ? RoundedText(*goal.value, 3) : "-") + (goal.met ? "" : " !"));
  }
  return row;
}

std::vector<std::vector<std::string>> GoalRows(const WhatIf& what_if, int best) {
  std::vector<std::vector<std::string>> rows;
  rows.push_back(GoalRow("the trial", what_if.trial_score, what_if.trial));
  const Outcome& line = what_if.outcomes.front();
  rows.push_back(GoalRow("its line", line.score, line.result.assessment));
  for (std::size_t n = 0; n < NumBest(what_if, best); ++n) {
    const Outcome& outcome = what_if.outcomes[what_if.ranking[n]];
    rows.push_back(GoalRow(Message("best ", n + 1), outcome.score, outcome.result.assessment));
  }
  return rows;
}

std::vector<std::vector<std::string>> SentenceRows(const TrialScene& scene, const WhatIf& what_if,
                                                   const std::vector<std::size_t>& numbers) {
  std::vector<std::vector<std::string>> rows;
  for (const std::size_t n : numbers) {
    const Outcome& outcome = what_if.outcomes[n];
    rows.push_back({ChangeText(what_if.line, outcome.alternative.change),
                    OutcomeText(what_if, outcome, scene.exercise.avoid),
                    FixedText(outcome.score, 3)});
  }
  return rows;
}

/// Indices of alternatives that change one value only: they come first.
std::vector<std::size_t> Singles(const WhatIf& what_if) {
  std::vector<std::size_t> numbers;
  for (std::size_t n = 0; n < what_if.outcomes.size(); ++n) {
    if (IsSingle(what_if.outcomes[n].alternative.change)) numbers.push_back(n);
  }
  return numbers;
}

void WritePage(const fs::path& path, const TrialScene& scene, const session::Session& trial,
               const WhatIf& what_if, const WhatIfSettings& settings, const RunContext& context) {
  report::HtmlReport html(scene.exercise.name + ": what if", trial.name);
  html.Section("Best alternatives");
  html.Paragraph(Message(
      what_if.outcomes.size(),
      " straight insertions were stepped in the trial's patient and judged by the exercise. Each "
      "begins ",
      RoundedText(settings.lead_mm, 3),
      " mm before the skin, so its times are those of the insertion alone. Distances in brackets "
      "are those of the trial's line: its last pass as one straight insertion."));
  const std::vector<std::size_t> best(
      what_if.ranking.begin(),
      what_if.ranking.begin() + static_cast<std::ptrdiff_t>(NumBest(what_if, settings.best)));
  const std::vector<std::string> header = {"change", "outcome", "score"};
  html.Table(header, SentenceRows(scene, what_if, best),
             "As sessions in sessions/best_1 and so on, for acus-replay");
  html.Table(GoalHeader(what_if), GoalRows(what_if, settings.best), "! goal not met");
  html.Section("Map on the skin");
  html.Drawing(SkinMapSvg(scene, trial, what_if),
               "Entries of all alternatives, the best on top; the mouse shows each. The ring is "
               "the trial's entry, the grey line 50 mm of the probe's face");
  html.Section("One change at a time");
  html.Table(header, SentenceRows(scene, what_if, Singles(what_if)));
  html.SetProvenance(context.provenance.ToJson());
  html.Write(path);
}

}  // namespace

void WriteWhatIf(const fs::path& folder, const TrialScene& scene, const session::Session& trial,
                 const WhatIf& what_if, const WhatIfSettings& settings, const RunContext& context) {
  WriteTextFile(folder / "what_if.csv", Table(what_if));
  config::WriteJson(folder / "what_if.json", Summary(scene, what_if, settings, context));
  WriteTextFile(folder / "map.svg", SkinMapSvg(scene, trial, what_if));
  WritePage(folder / "what_if.html", scene, trial, what_if, settings, context);
  const auto write = [&](const std::string& name, std::size_t number) {
    session::Session session =
        SessionOf(scene, trial, what_if.line, what_if.outcomes[number].alternative, settings);
    session.name = name;
    session::WriteSession(folder / "sessions" / name, session, context);
  };
  fs::create_directory(folder / "sessions");
  session::WriteSession(folder / "sessions" / "trial", trial, context);
  write("trial_line", 0);
  for (std::size_t n = 0; n < NumBest(what_if, settings.best); ++n) {
    write(Message("best_", n + 1), what_if.ranking[n]);
  }
  config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
}

std::string WhatIfText(const TrialScene& scene, const WhatIf& what_if, int best) {
  const training::Assessment& trial = what_if.trial;
  std::string text = Message("Trial: ", trial.NumMet(), " of ", trial.goals.size(), " goals met");
  if (const auto mm = ValueOf(trial, "tip to target at the end")) {
    text += Message(", ended ", FixedText(*mm, 1), " mm from the target");
  }
  text += Message(".\n", Counted(static_cast<std::int64_t>(what_if.outcomes.size()), "alternative"),
                  "; the best:\n");
  for (std::size_t n = 0; n < NumBest(what_if, best); ++n) {
    const Outcome& outcome = what_if.outcomes[what_if.ranking[n]];
    text += Message("  ", n + 1, ". ", ChangeText(what_if.line, outcome.alternative.change), ": ",
                    OutcomeText(what_if, outcome, scene.exercise.avoid), "\n");
  }
  for (const std::size_t n : what_if.ranking) {
    const InsertionChange& change = what_if.outcomes[n].alternative.change;
    if (!IsSingle(change)) continue;
    text += Message("With one change: ", ChangeText(what_if.line, change), ": ",
                    OutcomeText(what_if, what_if.outcomes[n], scene.exercise.avoid), "\n");
    break;
  }
  const double count = static_cast<double>(what_if.outcomes.size());
  return text + Message("CPU time of each: ", RoundedText(1e3 * what_if.cpu_s / count, 3),
                        " ms, of that ", RoundedText(1e3 * what_if.step_cpu_s / count, 3),
                        " ms of steps.\n");
}

}  // namespace acus::trials
