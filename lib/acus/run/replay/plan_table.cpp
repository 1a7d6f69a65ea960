#include "acus/run/replay/plan_table.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"

namespace acus::replay {
namespace {

using simulation::EffectPlan;
using simulation::PlannedStage;
using simulation::StageTimes;

double Percent(double part, double whole) {
  return whole > 0.0 ? 100.0 * part / whole : 0.0;
}

std::string Listed(const std::vector<effects::PortRef>& ports) {
  std::string text;
  for (const effects::PortRef port : ports) text += Message(text.empty() ? "" : ", ", port.name());
  return text;
}

std::string StateOf(const PlannedStage& stage, const StageTimes* times) {
  if (!stage.in) return "out";
  if (times == nullptr) return "in";
  const StageTimes::Cost& cost = times->Of(stage);
  return cost.runs > 0 && cost.asleep == cost.runs ? "asleep" : "in";
}

std::string TextOf(const PlanTable& table) {
  return TextTable(table.header, table.rows);
}

}  // namespace

PlanTable TableOfPlan(const EffectPlan& plan, const StageTimes* times) {
  PlanTable table{{"stage", "rate", "in", "reason"}, {}};
  double total_s = 0.0;
  if (times != nullptr) {
    table.header.insert(table.header.end(), {"runs", "asleep %", "CPU ms", "us/run", "share %"});
    for (const auto& stage : plan.stages()) total_s += times->Of(stage).seconds;
  }
  for (const auto& stage : plan.stages()) {
    std::vector<std::string> row{std::string(stage.name), std::string(stage.rate),
                                 StateOf(stage, times), stage.reason};
    if (times != nullptr) {
      const auto& cost = times->Of(stage);
      const double runs = static_cast<double>(std::max<std::int64_t>(cost.runs, 1));
      row.insert(
          row.end(),
          {std::to_string(cost.runs), FixedText(Percent(static_cast<double>(cost.asleep), runs), 1),
           FixedText(1e3 * cost.seconds, 1), FixedText(1e6 * cost.seconds / runs, 2),
           FixedText(Percent(cost.seconds, total_s), 1)});
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

PlanTable FlowOfPlan(const EffectPlan& plan) {
  PlanTable table{{"stage", "writes", "reads"}, {}};
  for (const auto& stage : plan.stages()) {
    if (!stage.in) continue;
    table.rows.push_back({std::string(stage.name), Listed(stage.writes), Listed(stage.reads)});
  }
  return table;
}

std::vector<std::string> SleepLines(const EffectPlan& plan, const StageTimes& times) {
  struct Line {
    double percent;
    std::string text;
  };
  std::vector<Line> lines;
  for (const auto& stage : plan.stages()) {
    const auto& cost = times.Of(stage);
    for (std::size_t r = 0; r < cost.asleep_for.size(); ++r) {
      if (cost.asleep_for[r] == 0) continue;
      const double percent =
          Percent(static_cast<double>(cost.asleep_for[r]), static_cast<double>(cost.runs));
      lines.push_back(
          {percent, Message(stage.name, ": ", WordsOf(static_cast<simulation::Sleep>(r)), " in ",
                            RoundedText(percent, 2), " % of the ", stage.rate, "s")});
    }
  }
  std::ranges::stable_sort(lines, std::ranges::greater(), &Line::percent);
  std::vector<std::string> texts;
  for (Line& line : lines) texts.push_back(std::move(line.text));
  return texts;
}

std::string PlanText(const EffectPlan& plan, const StageTimes* times) {
  std::string text = TextOf(TableOfPlan(plan, times)) + "\n" + TextOf(FlowOfPlan(plan));
  if (times == nullptr) return text;
  const auto lines = SleepLines(plan, *times);
  if (!lines.empty()) text += "\nAsleep:\n";
  for (const std::string& line : lines) text += "  " + line + "\n";
  return text;
}

}  // namespace acus::replay
