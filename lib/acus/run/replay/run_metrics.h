// The metrics of a run.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/data/session/session.h"
#include "acus/run/replay/step_log.h"
#include "acus/run/training/exercise.h"
#include "acus/run/training/metric.h"

namespace acus::replay {

using training::Metric;

/// Metrics of the session: elapsed time and path lengths of needle and probe; with a label map,
/// those of training::NeedleMetricsOf. Metrics of the forces: largest and RMS axial and lateral
/// force, punctures, bone contacts, greatest depth. For a needle that bends, its largest
/// deflection. For the probe: largest force, depth, time on skin and bone.
/// @param exercise  If given, its definitions of passes and of the image plane hold.
std::vector<Metric> MetricsOf(const simulation::Scene& scene, const session::Session& session,
                              const StepLog& log, const training::Exercise* exercise = nullptr);

/// metrics.json: {"format": "acus-metrics/1", "metrics": [{"name", "unit", "value"}, ...]}.
void WriteMetrics(const std::filesystem::path& path, const std::vector<Metric>& metrics);

}  // namespace acus::replay
