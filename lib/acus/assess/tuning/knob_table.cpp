// The parameters of a scenario: declarations of its effects, with defaults and current values.
#include <utility>

#include "acus/assess/tuning/knob.h"
#include "acus/base/core/error.h"
#include "acus/scene/simulation/coupled/coupled_effect.h"

namespace acus::tuning {
namespace {

using nlohmann::json;
using scenario::Scenario;

/// The schema's default at a pointer; null if there is none.
json SchemaDefault(const json& schema, const std::string& pointer) {
  const json* node = &schema;
  json::json_pointer place(pointer);
  std::vector<std::string> keys;
  for (; !place.empty(); place.pop_back()) keys.push_back(place.back());
  for (auto key = keys.rbegin(); key != keys.rend(); ++key) node = &node->at("properties").at(*key);
  return node->value("default", json());
}

Knob KnobOf(effects::Knob declared, std::string_view effect, const Scenario& scenario,
            const json& schema) {
  const std::string pointer = declared.key.starts_with('/')
                                  ? declared.key
                                  : Message("/effects/", effect, "/", declared.key);
  Knob knob{std::move(declared), {pointer}};
  if (knob.default_value.is_null()) knob.default_value = SchemaDefault(schema, pointer);
  const json::json_pointer place(pointer);
  if (knob.scenario_value.is_null() && scenario.effective.contains(place)) {
    knob.scenario_value = scenario.effective.at(place);
  }
  return knob;
}

/// The rate at which the session is stepped.
Knob StepRate(double recorded_rate_hz) {
  Knob rate;
  rate.name = "step_rate_hz";
  rate.title = "steps per second";
  rate.unit = "Hz";
  rate.acts_on = ActsOn::kForce;
  rate.values = {500, 1000, 2000, 4000};
  rate.scenario_value = recorded_rate_hz;
  rate.papers = {{1000, "Augmented-2010; Vidal-2008"}, {2000, "Fortmeier-2016"}};
  return rate;
}

}  // namespace

std::vector<Knob> KnobsOf(const Scenario& scenario, double recorded_rate_hz) {
  const json schema = scenario::ScenarioSchema();
  std::vector<Knob> knobs;
  const auto add = [&](std::vector<effects::Knob> declared, std::string_view effect) {
    for (effects::Knob& knob : declared) {
      knobs.push_back(KnobOf(std::move(knob), effect, scenario, schema));
    }
  };
  for (const simulation::CoupledEffect* effect : simulation::CoupledEffects()) {
    add(effect->Knobs(scenario), effect->key());
  }
  for (const effects::CalledEffect& called : scenario.listed) {
    add(called.effect->Knobs(), called.effect->key());
  }
  const bool steps = scenario.needle_force || scenario.probe_force || scenario.tissue;
  if (steps && recorded_rate_hz > 0.0) knobs.push_back(StepRate(recorded_rate_hz));
  for (Knob& knob : knobs) {
    const bool are_numbers = knob.values.size() >= 2 && knob.values.front().is_number();
    knob.falls = are_numbers && knob.values.front() > knob.values.back();
  }
  return knobs;
}

}  // namespace acus::tuning
