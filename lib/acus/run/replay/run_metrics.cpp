#include "acus/run/replay/run_metrics.h"

#include "acus/base/config/json_file.h"
#include "acus/run/replay/effect_meters.h"
#include "acus/run/replay/force_meter.h"
#include "acus/run/training/session_metrics.h"

namespace acus::replay {
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
  ForceMeter meter;
  EffectMeters effects(scene);
  for (const simulation::StepOutput& step : log.steps) {
    meter.Add(step);
    effects.Add(step);
  }
  for (const auto& measured : {meter.Metrics(scene), effects.Metrics()}) {
    metrics.insert(metrics.end(), measured.begin(), measured.end());
  }
  if (scene.shape && scene.shape->bendable() && !log.steps.empty()) {
    const double most_mm =
        log.most_bent.empty() ? 0.0 : log.steps[log.most_bent_step].shape.tip_deflection_mm;
    metrics.push_back({"largest tip deflection", "mm", most_mm});
  }
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
