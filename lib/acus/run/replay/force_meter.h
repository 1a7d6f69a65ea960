// Metrics of the forces on needle and probe, step by step.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "acus/run/training/metric.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/simulation.h"

namespace acus::replay {

class ForceMeter {
 public:
  void Add(const simulation::StepOutput& step);
  /// Metrics of the forces in the scene's plan; none before the first step.
  std::vector<training::Metric> Metrics(const simulation::Scene& scene) const;

 private:
  double SpanS() const { return 1e-9 * static_cast<double>(last_ns_ - first_ns_.value_or(0)); }
  void AddNeedle(std::vector<training::Metric>& metrics) const;
  void AddProbe(std::vector<training::Metric>& metrics) const;

  std::optional<std::int64_t> first_ns_;
  std::int64_t last_ns_ = 0;
  double steps_ = 0.0;
  double largest_axial_n_ = 0.0;
  double largest_lateral_n_ = 0.0;
  double greatest_depth_mm_ = 0.0;
  double sum_of_squares_ = 0.0;
  double inserted_ = 0.0;
  double needle_on_bone_ = 0.0;
  double punctures_ = 0.0;
  double bone_contacts_ = 0.0;
  double largest_probe_n_ = 0.0;
  double deepest_probe_mm_ = 0.0;
  double probe_on_skin_ = 0.0;
  double probe_on_bone_ = 0.0;
};

}  // namespace acus::replay
