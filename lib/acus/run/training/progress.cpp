#include "acus/run/training/progress.h"

#include <algorithm>
#include <map>
#include <sstream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/report/html_report.h"

namespace acus::training {
namespace {

namespace fs = std::filesystem;

std::string WithUnit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : Message(name, " [", unit, "]");
}

std::string ValueText(const GoalResult& result) {
  if (!result.value) return "-";
  return Message(RoundedText(*result.value, 3), result.met ? "" : " !");
}

constexpr const char* kSigns = "! goal not met, - no value: no insertion, or not reached";

std::string TraineeOf(const Assessment& session) {
  return session.trainee.empty() ? "-" : session.trainee;
}

std::vector<std::string> Header(const Assessment& session) {
  std::vector<std::string> header = {"trainee", "session", "goals met"};
  for (const GoalResult& goal : session.goals) {
    header.push_back(WithUnit(goal.goal.metric, goal.unit));
  }
  return header;
}

std::vector<std::vector<std::string>> Rows(std::span<const Assessment> sessions) {
  std::vector<std::vector<std::string>> rows;
  for (const Assessment& session : sessions) {
    rows.push_back({TraineeOf(session), session.session,
                    Message(session.NumMet(), " of ", session.goals.size(),
                            session.Passed() ? "" : ", failed")});
    for (const GoalResult& goal : session.goals) rows.back().push_back(ValueText(goal));
  }
  return rows;
}

/// A goal over the sessions of each trainee, with its limits.
report::Plot PlotOfGoal(std::span<const Assessment> sessions, std::size_t goal) {
  std::map<std::string, report::Series> by_trainee;
  for (const Assessment& session : sessions) {
    report::Series& series = by_trainee[TraineeOf(session)];
    series.name = TraineeOf(session);
    // A session without a value still counts: the numbers of later ones do not change.
    const double number =
        1.0 + static_cast<double>(std::ranges::count(std::span(sessions.data(), &session),
                                                     TraineeOf(session), &TraineeOf));
    if (!session.goals[goal].value) continue;
    series.x.push_back(number);
    series.y.push_back(*session.goals[goal].value);
  }
  const GoalResult& first = sessions.front().goals[goal];
  report::Plot plot;
  plot.title = WithUnit(first.goal.metric, first.unit);
  plot.x_label = "session";
  plot.y_label = first.unit.empty() ? "count" : Message("[", first.unit, "]");
  plot.y_from_zero = true;
  plot.height_px = 200;
  for (auto& [trainee, series] : by_trainee) {
    report::Series dots{.name = {}, .x = series.x, .y = series.y, .style = report::Style::kPoints};
    plot.series.push_back(std::move(series));
    plot.series.push_back(std::move(dots));
  }
  for (const auto& [words, limit] : {std::pair{"goal: at most ", first.goal.at_most},
                                     {"goal: at least ", first.goal.at_least}}) {
    if (limit) plot.limits.push_back({*limit, Message(words, RoundedText(*limit, 4))});
  }
  return plot;
}

/// All metrics that any session has, in the order of the first that has them.
std::vector<std::string> MetricColumns(std::span<const Assessment> sessions) {
  std::vector<std::string> columns;
  for (const Assessment& session : sessions) {
    for (const Metric& metric : session.metrics) {
      const std::string name = WithUnit(metric.name, metric.unit);
      if (std::ranges::find(columns, name) == columns.end()) columns.push_back(name);
    }
  }
  return columns;
}

/// Names as cells of CSV, which have no quotes here.
std::string Cell(std::string text) {
  std::ranges::replace(text, ',', ';');
  return text;
}

std::string CsvText(std::span<const Assessment> sessions) {
  const std::vector<std::string> columns = MetricColumns(sessions);
  std::ostringstream csv;
  csv << "trainee,session,exercise,goals_met,goals";
  for (const std::string& column : columns) csv << ',' << Cell(column);
  csv << '\n';
  for (const Assessment& session : sessions) {
    csv << Cell(session.trainee) << ',' << Cell(session.session) << ',' << Cell(session.exercise)
        << ',' << session.NumMet() << ',' << session.goals.size();
    for (const std::string& column : columns) {
      const auto metric = std::ranges::find_if(
          session.metrics, [&](const Metric& m) { return WithUnit(m.name, m.unit) == column; });
      csv << ',';
      if (metric != session.metrics.end()) csv << NumberText(metric->value);
    }
    csv << '\n';
  }
  return csv.str();
}

}  // namespace

std::vector<Assessment> ReadAssessments(std::span<const fs::path> runs) {
  std::vector<Assessment> sessions;
  for (const fs::path& run : runs) {
    const fs::path file = run / "training.json";
    ACUS_REQUIRE(fs::exists(file), run.string(),
                 ": has no training.json; make the run with acus-replay --exercise");
    sessions.push_back(ReadAssessment(file));
    const Assessment& first = sessions.front();
    const Assessment& last = sessions.back();
    ACUS_REQUIRE(last.exercise == first.exercise, run.string(), ": is a session of \"",
                 last.exercise, "\", the first one of \"", first.exercise,
                 "\"; only sessions of one exercise can be compared");
    ACUS_REQUIRE(std::ranges::equal(
                     last.goals, first.goals, {}, [](const GoalResult& g) { return g.goal.metric; },
                     [](const GoalResult& g) { return g.goal.metric; }),
                 run.string(), ": has other goals than the first session; replay both with the ",
                 "same exercise file");
  }
  return sessions;
}

std::string ProgressText(std::span<const Assessment> sessions) {
  return TextTable(Header(sessions.front()), Rows(sessions)) + kSigns + "\n";
}

void WriteProgress(const fs::path& folder, std::span<const Assessment> sessions,
                   const RunContext& context,
                   const std::function<void(report::HtmlReport&)>& add_sections) {
  WriteTextFile(folder / "progress.csv", CsvText(sessions));
  report::HtmlReport html(sessions.front().exercise, "Progress from session to session");
  html.Section("Sessions");
  html.Table(Header(sessions.front()), Rows(sessions), kSigns);
  if (add_sections) add_sections(html);
  html.Section("Goals");
  for (std::size_t goal = 0; goal < sessions.front().goals.size(); ++goal) {
    html.Plots(std::vector{PlotOfGoal(sessions, goal)}, sessions.front().goals[goal].goal.why);
  }
  html.SetProvenance(context.provenance.ToJson());
  html.Write(folder / "progress.html");
  config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
}

}  // namespace acus::training
