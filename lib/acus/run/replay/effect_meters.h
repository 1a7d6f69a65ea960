// What the effects of a scene measure, step by step.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acus/run/training/metric.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/simulation.h"

namespace acus::replay {

class EffectMeters {
 public:
  /// @param scene  Must outlive this.
  explicit EffectMeters(const simulation::Scene& scene);

  /// Each step in turn; times count from the first.
  void Add(const simulation::StepOutput& step);
  /// In the order of the effects; none before the first step.
  std::vector<training::Metric> Metrics() const;
  /// Sentences of an effect for reports.
  std::vector<std::string> FindingsOf(std::string_view key) const;

 private:
  struct Meter {
    const simulation::ListedEffect* effect = nullptr;
    std::shared_ptr<effects::EffectMeter> meter;
  };
  std::vector<Meter> meters_;
  std::optional<std::int64_t> first_ns_;
};

}  // namespace acus::replay
