#include "acus/run/replay/effect_meters.h"

#include <span>

namespace acus::replay {

EffectMeters::EffectMeters(const simulation::Scene& scene) {
  for (const simulation::ListedEffect& effect : scene.listed.all()) {
    if (effect.step == nullptr) continue;
    if (std::shared_ptr<effects::EffectMeter> meter = effect.loaded->NewMeter()) {
      meters_.push_back({&effect, std::move(meter)});
    }
  }
}

void EffectMeters::Add(const simulation::StepOutput& step) {
  if (meters_.empty()) return;
  if (!first_ns_) first_ns_ = step.time_ns;
  const double session_s = 1e-9 * static_cast<double>(step.time_ns - *first_ns_);
  for (const Meter& of : meters_) {
    of.meter->Add(
        session_s,
        std::span(step.effect).subspan(of.effect->first_column, of.effect->columns.size()));
  }
}

std::vector<training::Metric> EffectMeters::Metrics() const {
  std::vector<training::Metric> metrics;
  if (!first_ns_) return metrics;
  for (const Meter& of : meters_) {
    for (effects::MeasuredValue& measured : of.meter->Values()) {
      metrics.push_back({std::move(measured.name), std::move(measured.unit), measured.value});
    }
  }
  return metrics;
}

std::vector<std::string> EffectMeters::FindingsOf(std::string_view key) const {
  for (const Meter& of : meters_) {
    if (of.effect->key == key && first_ns_) return of.meter->Findings();
  }
  return {};
}

}  // namespace acus::replay
