// The score of a session: how close it came to the goals of its exercise.
#pragma once

#include "acus/run/training/assessment.h"

namespace acus::training {

/// In [0, 1], 1 if all goals are met. The weighted mean over the goals of 1 for a goal that is met,
/// else s / (s + e), with e the excess of the value over the limit and s the limit's magnitude (1
/// for a limit of 0); 0 for a goal without a value. Multiplied by that share for each `must` goal
/// that is not met. Continuous at the limits. 1 without goals.
double ScoreOf(const Assessment& assessment);

}  // namespace acus::training
