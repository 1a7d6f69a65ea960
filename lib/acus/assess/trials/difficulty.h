// Difficulty of an exercise for virtual trainees.
#pragma once

#include "acus/assess/trials/planned_path.h"
#include "acus/assess/trials/trainee.h"
#include "acus/assess/trials/trial_scene.h"
#include "acus/base/core/run_context.h"
#include "acus/base/math/bootstrap.h"

namespace acus::trials {

/// 1 - mean score, from 0 (all goals are always met) to 1. The interval is the 95 % interval of the
/// persons' means, by bootstrap.
struct Difficulty {
  double value = 0.0;
  math::Interval interval;
};

struct DifficultyOptions {
  TraineeSkill grade;
  int persons = 12;
  int trials = 1;  ///< Trials of each person.
  double rate_hz = 1000.0;
};

/// Depends on the scene, the options and the context's seed only.
/// @throws InputError if a goal's metric does not exist.
Difficulty DifficultyOf(const TrialScene& scene, const PlannedPath& path,
                        const DifficultyOptions& options, const RunContext& context);

}  // namespace acus::trials
