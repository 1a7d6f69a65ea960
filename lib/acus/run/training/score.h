// One number for how near a session came to the goals of its exercise.
#pragma once

#include "acus/run/training/assessment.h"

namespace acus::training {

/// In [0, 1], 1 if all goals are met: the weighted mean over the goals of 1 for a goal that is met,
/// else s / (s + e), with e how far the value is beyond the limit and s the limit's size (1 for a
/// limit of 0); 0 for a goal without a value. Times that share of each must that is not met.
/// Continuous at the limits. 1 without goals.
double ScoreOf(const Assessment& assessment);

}  // namespace acus::training
