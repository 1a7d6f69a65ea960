#include "acus/scene/simulation/plan_json.h"

#include <nlohmann/json.hpp>

namespace acus::simulation {

namespace {

nlohmann::json NamesOf(const std::vector<effects::PortRef>& ports) {
  nlohmann::json names = nlohmann::json::array();
  for (const effects::PortRef port : ports) names.push_back(port.name());
  return names;
}

}  // namespace

nlohmann::json PlanJson(const EffectPlan& plan, const StageTimes& times) {
  nlohmann::json stages = nlohmann::json::array();
  for (const PlannedStage& stage : plan.stages()) {
    const StageTimes::Cost& cost = times.Of(stage);
    nlohmann::json because = nlohmann::json::object();
    for (std::size_t r = 0; r < cost.asleep_for.size(); ++r) {
      if (cost.asleep_for[r] == 0) continue;
      because[std::string(WordsOf(static_cast<Sleep>(r)))] = cost.asleep_for[r];
    }
    stages.push_back({{"stage", stage.name},
                      {"rate", stage.rate},
                      {"in", stage.in},
                      {"reason", stage.reason},
                      {"effects", stage.effects},
                      {"reads", NamesOf(stage.reads)},
                      {"writes", NamesOf(stage.writes)},
                      {"runs", cost.runs},
                      {"asleep", cost.asleep},
                      {"asleep_because", because},
                      {"seconds", cost.seconds}});
  }
  return stages;
}

}  // namespace acus::simulation
