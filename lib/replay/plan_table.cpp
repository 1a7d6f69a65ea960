#include "replay/plan_table.h"

#include <algorithm>

#include "core/text_table.h"

namespace acus::replay {

PlanTable TableOfPlan(const simulation::EffectPlan& plan, const simulation::StageTimes* times) {
  PlanTable table{{"stage", "rate", "in", "reason"}, {}};
  double total_s = 0.0;
  if (times != nullptr) {
    table.header.insert(table.header.end(), {"runs", "asleep", "wall ms", "us/run", "share %"});
    for (const auto& stage : plan.stages()) total_s += times->Of(stage.id).seconds;
  }
  for (const auto& stage : plan.stages()) {
    std::vector<std::string> row{std::string(stage.name), std::string(stage.rate),
                                 stage.in ? "in" : "out", stage.reason};
    if (times != nullptr) {
      const auto& cost = times->Of(stage.id);
      const double runs = static_cast<double>(std::max<std::int64_t>(cost.runs, 1));
      row.insert(row.end(),
                 {std::to_string(cost.runs), std::to_string(cost.asleep),
                  FixedText(1e3 * cost.seconds, 1), FixedText(1e6 * cost.seconds / runs, 2),
                  FixedText(total_s > 0.0 ? 100.0 * cost.seconds / total_s : 0.0, 1)});
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace acus::replay
