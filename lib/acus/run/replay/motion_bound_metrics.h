// Bounds on the error of the tissue's motion by breathing at needle and target in a run.
#pragma once

#include <vector>

#include "acus/data/session/session.h"
#include "acus/data/transforms/landmarks.h"
#include "acus/run/replay/step_log.h"
#include "acus/run/training/metric.h"
#include "acus/scene/simulation/breathing_scene.h"

namespace acus::replay {

/// The 95 % bound on the error of the motion model, mm: its largest value at the tip and that in
/// the last step, and its largest value at the targets over the run. Grows with the breath. Nothing
/// if the motion has no bound, or nothing moves.
/// @param targets_in_ct_mm  At rest; may be empty.
std::vector<training::Metric> MotionBoundMetrics(const simulation::Breathing& breathing,
                                                 const session::Session& session,
                                                 const StepLog& log,
                                                 const transforms::Markers& targets_in_ct_mm);

}  // namespace acus::replay
