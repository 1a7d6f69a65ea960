// How far the tissue at needle and target may be from where a run's breathing puts it.
#pragma once

#include <vector>

#include "acus/data/session/session.h"
#include "acus/data/transforms/landmarks.h"
#include "acus/run/replay/step_log.h"
#include "acus/run/training/metric.h"
#include "acus/scene/simulation/breathing_scene.h"

namespace acus::replay {

/// The bound on the motion's error that 95 of 100 places keep, mm: at the tip its largest value
/// and the one in the last step, and its largest at the targets over the run. Grows with the
/// breath. Nothing if the motion has no bound, or nothing moves.
/// @param targets_in_ct_mm  At rest; may be empty.
std::vector<training::Metric> MotionBoundMetrics(const simulation::Breathing& breathing,
                                                 const session::Session& session,
                                                 const StepLog& log,
                                                 const transforms::Markers& targets_in_ct_mm);

}  // namespace acus::replay
