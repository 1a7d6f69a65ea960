#include "replay/plan_table.h"

#include <algorithm>
#include <cstdio>

namespace acus::replay {
namespace {

std::string Fixed(double value, int decimals) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

}  // namespace

PlanTable TableOfPlan(const simulation::EffectPlan& plan, const simulation::StageTimes* times) {
  PlanTable table{{"stage", "rate", "in", "reason"}, {}};
  double total_s = 0.0;
  if (times != nullptr) {
    table.header.insert(table.header.end(), {"runs", "asleep", "ms", "us/run", "share %"});
    for (const auto& stage : plan.stages()) total_s += times->Of(stage.id).seconds;
  }
  for (const auto& stage : plan.stages()) {
    std::vector<std::string> row{std::string(stage.name), std::string(stage.rate),
                                 stage.in ? "in" : "out", stage.reason};
    if (times != nullptr) {
      const auto& cost = times->Of(stage.id);
      const double runs = static_cast<double>(std::max<std::int64_t>(cost.runs, 1));
      row.insert(row.end(), {std::to_string(cost.runs), std::to_string(cost.asleep),
                             Fixed(1e3 * cost.seconds, 1), Fixed(1e6 * cost.seconds / runs, 2),
                             Fixed(total_s > 0.0 ? 100.0 * cost.seconds / total_s : 0.0, 1)});
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string AlignedText(const PlanTable& table) {
  std::vector<std::size_t> width(table.header.size());
  const auto widen = [&width](const std::vector<std::string>& row) {
    for (std::size_t i = 0; i < row.size(); ++i) width[i] = std::max(width[i], row[i].size());
  };
  widen(table.header);
  for (const auto& row : table.rows) widen(row);
  std::string text;
  const auto add = [&](const std::vector<std::string>& row) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string gap(width[i] - row[i].size(), ' ');
      const bool number = i >= 4;  // Set flush right.
      line += number ? gap + row[i] + "  " : row[i] + gap + "  ";
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  };
  add(table.header);
  for (const auto& row : table.rows) add(row);
  return text;
}

}  // namespace acus::replay
