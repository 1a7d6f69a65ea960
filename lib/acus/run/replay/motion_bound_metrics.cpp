#include "acus/run/replay/motion_bound_metrics.h"

#include <algorithm>

namespace acus::replay {

std::vector<training::Metric> MotionBoundMetrics(const simulation::Breathing& breathing,
                                                 const session::Session& session,
                                                 const StepLog& log,
                                                 const transforms::Markers& targets_in_ct_mm) {
  if (!breathing.motion.bound || breathing.amplitude == 0.0 || log.steps.empty()) return {};
  const breathing::MotionBound& bound = *breathing.motion.bound;
  double largest_mm = 0.0, last_mm = 0.0, targets_mm = 0.0;
  for (const simulation::StepOutput& step : log.steps) {
    const double session_s = 1e-9 * static_cast<double>(step.time_ns - session.start_ns());
    const breathing::Breath breath =
        breathing.from_session ? BreathOf(session, step.time_ns) : breathing.NormalAt(session_s);
    const double level = breathing.amplitude * breath.level;
    last_mm = bound.Mm(step.needle_at_rest.ct_from_tool.translation(), level);
    largest_mm = std::max(largest_mm, last_mm);
    for (Eigen::Index n = 0; n < targets_in_ct_mm.cols(); ++n) {
      targets_mm = std::max(targets_mm, bound.Mm(targets_in_ct_mm.col(n), level));
    }
  }
  std::vector<training::Metric> metrics = {{"largest motion bound at the tip", "mm", largest_mm},
                                           {"last motion bound at the tip", "mm", last_mm}};
  if (targets_in_ct_mm.cols() > 0) {
    metrics.push_back({"largest motion bound at the targets", "mm", targets_mm});
  }
  return metrics;
}

}  // namespace acus::replay
