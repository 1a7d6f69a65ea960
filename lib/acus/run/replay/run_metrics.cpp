#include "acus/run/replay/run_metrics.h"

#include <algorithm>
#include <cmath>

#include "acus/base/config/json_file.h"
#include "acus/run/training/session_metrics.h"

namespace acus::replay {
namespace {

using forces::NeedleEvent;

int CountOf(const StepLog& log, NeedleEvent event) {
  return static_cast<int>(std::ranges::count_if(
      log.steps, [event](const auto& step) { return step.force.event == event; }));
}

void AddForces(const StepLog& log, std::vector<Metric>& metrics) {
  double largest_axial_n = 0.0;
  double largest_lateral_n = 0.0;
  double greatest_depth_mm = 0.0;
  double sum_of_squares = 0.0;
  double inserted = 0.0;
  double on_bone = 0.0;
  for (const simulation::StepOutput& step : log.steps) {
    const forces::NeedleForce& f = step.force;
    largest_axial_n = std::max(largest_axial_n, std::abs(f.AxialN()));
    largest_lateral_n = std::max(largest_lateral_n, f.lateral_n);
    greatest_depth_mm = std::max(greatest_depth_mm, f.depth_mm);
    if (f.bone_n > 0.0) on_bone += 1.0;
    if (f.depth_mm <= 0.0) continue;
    inserted += 1.0;
    sum_of_squares += f.AxialN() * f.AxialN();
  }
  const double n = static_cast<double>(log.steps.size());
  const double span_s =
      1e-9 * static_cast<double>(log.steps.back().time_ns - log.steps.front().time_ns);
  metrics.push_back({"largest axial force", "N", largest_axial_n});
  metrics.push_back({"RMS axial force while inserted", "N",
                     inserted > 0.0 ? std::sqrt(sum_of_squares / inserted) : 0.0});
  metrics.push_back({"largest lateral force", "N", largest_lateral_n});
  metrics.push_back({"greatest depth", "mm", greatest_depth_mm});
  metrics.push_back({"time on bone", "s", span_s * on_bone / n});
  metrics.push_back({"punctures", "", static_cast<double>(CountOf(log, NeedleEvent::kPuncture))});
  metrics.push_back(
      {"bone contacts", "", static_cast<double>(CountOf(log, NeedleEvent::kBoneContact))});
}

void AddProbeForces(const StepLog& log, std::vector<Metric>& metrics) {
  double largest_n = 0.0;
  double deepest_mm = 0.0;
  double on_skin = 0.0;
  double on_bone = 0.0;
  for (const simulation::StepOutput& step : log.steps) {
    largest_n = std::max(largest_n, step.probe.force_in_ct_n.norm());
    deepest_mm = std::max(deepest_mm, step.probe.skin_mm);
    if (step.probe.on_skin) on_skin += 1.0;
    if (step.probe.on_bone) on_bone += 1.0;
  }
  const double n = static_cast<double>(log.steps.size());
  const double span_s =
      1e-9 * static_cast<double>(log.steps.back().time_ns - log.steps.front().time_ns);
  metrics.push_back({"largest probe force", "N", largest_n});
  metrics.push_back({"greatest depth of the probe", "mm", deepest_mm});
  metrics.push_back({"probe time on the skin", "s", span_s * on_skin / n});
  metrics.push_back({"probe time on bone", "s", span_s * on_bone / n});
}

}  // namespace

std::vector<Metric> MetricsOf(const simulation::Scene& scene, const session::Session& session,
                              const StepLog& log, const training::Exercise* exercise) {
  std::vector<Metric> metrics = training::MotionMetricsOf(session);
  if (scene.labels && !session.needle.empty()) {
    const auto needle = training::NeedleMetricsOf(
        session, {*scene.labels, scene.ct_from_reference},
        exercise == nullptr ? training::PassOptions{} : exercise->passes,
        exercise == nullptr ? training::PlaneOptions{} : exercise->image_plane);
    metrics.insert(metrics.end(), needle.begin(), needle.end());
  }
  const bool forces = scene.plan.Has(simulation::StageId::kNeedleForce) && !log.steps.empty();
  if (forces) AddForces(log, metrics);
  if (scene.shape && scene.shape->bendable() && !log.steps.empty()) {
    const double most_mm =
        log.most_bent.empty() ? 0.0 : log.steps[log.most_bent_step].shape.tip_deflection_mm;
    metrics.push_back({"largest tip deflection", "mm", most_mm});
  }
  const bool probe = scene.plan.Has(simulation::StageId::kProbeForce) && !log.steps.empty();
  if (probe) AddProbeForces(log, metrics);
  return metrics;
}

void WriteMetrics(const std::filesystem::path& path, const std::vector<Metric>& metrics) {
  nlohmann::json list = nlohmann::json::array();
  for (const Metric& metric : metrics) {
    list.push_back({{"name", metric.name}, {"unit", metric.unit}, {"value", metric.value}});
  }
  config::WriteJson(path, {{"format", "acus-metrics/1"}, {"metrics", list}});
}

}  // namespace acus::replay
