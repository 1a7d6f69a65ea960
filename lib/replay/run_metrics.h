// The numbers that come out of a run.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "replay/step_log.h"
#include "session/session.h"

namespace acus::replay {

struct Metric {
  std::string name;
  std::string unit;
  double value = 0.0;
};

/// Of the session: elapsed time and path lengths of needle and probe; with a label map, time and
/// path in tissue. Of the forces: largest and RMS axial and lateral force, impulse, insertions,
/// punctures, bone contacts, greatest depth. Of a needle that bends: its largest deflection. Of the
/// probe: largest force, depth, time on skin and bone.
std::vector<Metric> MetricsOf(const simulation::Scene& scene, const session::Session& session,
                              const StepLog& log);

/// metrics.json: {"format": "acus-metrics/1", "metrics": [{"name", "unit", "value"}, ...]}.
void WriteMetrics(const std::filesystem::path& path, const std::vector<Metric>& metrics);

}  // namespace acus::replay
