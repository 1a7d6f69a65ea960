#include "acus/run/replay/force_meter.h"

#include <algorithm>
#include <cmath>

namespace acus::replay {

using forces::NeedleEvent;
using training::Metric;

void ForceMeter::Add(const simulation::StepOutput& step) {
  if (!first_ns_) first_ns_ = step.time_ns;
  last_ns_ = step.time_ns;
  steps_ += 1.0;
  const forces::NeedleForce& f = step.force;
  largest_axial_n_ = std::max(largest_axial_n_, std::abs(f.AxialN()));
  largest_lateral_n_ = std::max(largest_lateral_n_, f.lateral_n);
  greatest_depth_mm_ = std::max(greatest_depth_mm_, f.depth_mm);
  if (f.bone_n > 0.0) needle_on_bone_ += 1.0;
  if (f.event == NeedleEvent::kPuncture) punctures_ += 1.0;
  if (f.event == NeedleEvent::kBoneContact) bone_contacts_ += 1.0;
  if (f.depth_mm > 0.0) {
    inserted_ += 1.0;
    sum_of_squares_ += f.AxialN() * f.AxialN();
  }
  largest_probe_n_ = std::max(largest_probe_n_, step.probe.force_in_ct_n.norm());
  deepest_probe_mm_ = std::max(deepest_probe_mm_, step.probe.skin_mm);
  if (step.probe.on_skin) probe_on_skin_ += 1.0;
  if (step.probe.on_bone) probe_on_bone_ += 1.0;
}

void ForceMeter::AddNeedle(std::vector<Metric>& metrics) const {
  metrics.push_back({"largest axial force", "N", largest_axial_n_});
  metrics.push_back({"RMS axial force while inserted", "N",
                     inserted_ > 0.0 ? std::sqrt(sum_of_squares_ / inserted_) : 0.0});
  metrics.push_back({"largest lateral force", "N", largest_lateral_n_});
  metrics.push_back({"greatest depth", "mm", greatest_depth_mm_});
  metrics.push_back({"time on bone", "s", SpanS() * needle_on_bone_ / steps_});
  metrics.push_back({"punctures", "", punctures_});
  metrics.push_back({"bone contacts", "", bone_contacts_});
}

void ForceMeter::AddProbe(std::vector<Metric>& metrics) const {
  metrics.push_back({"largest probe force", "N", largest_probe_n_});
  metrics.push_back({"greatest depth of the probe", "mm", deepest_probe_mm_});
  metrics.push_back({"probe time on the skin", "s", SpanS() * probe_on_skin_ / steps_});
  metrics.push_back({"probe time on bone", "s", SpanS() * probe_on_bone_ / steps_});
}

std::vector<Metric> ForceMeter::Metrics(const simulation::Scene& scene) const {
  std::vector<Metric> metrics;
  if (!first_ns_) return metrics;
  if (scene.plan.Writes(effects::ports::kForce)) AddNeedle(metrics);
  if (scene.plan.Writes(effects::ports::kProbeForce)) AddProbe(metrics);
  return metrics;
}

}  // namespace acus::replay
