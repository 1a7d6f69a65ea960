// A thousand alternatives to a trial take at most 30 s on two cores.
#include <cstdio>

#include "acus/assess/trials/what_if.h"
#include "acus/base/core/cpu_time.h"
#include "support/trial_folder.h"

namespace acus::trials {
namespace {

class WhatIfSpeed : public testing_support::TrialFolder {};

TEST_F(WhatIfSpeed, AThousandAlternativesTakeThirtySecondsOnTwoCores) {
  const session::Session trial = Insertion();
  const TrialScene scene = Loaded(trial);
  WhatIfSettings settings;
  settings.count = 200;
  const WhatIf what_if = RunWhatIf(scene, trial, settings, context_);
  const double cpu_s = 1000.0 / settings.count * what_if.cpu_s;
  std::printf("1000 alternatives: %.1f s of CPU time, of that %.1f s of steps\n", cpu_s,
              1000.0 / settings.count * what_if.step_cpu_s);
  EXPECT_LT(cpu_s, 2.0 * 30.0);
  // What was fast is right: the best of all is its full replay, and aims well.
  const Outcome& best = what_if.outcomes[what_if.ranking.front()];
  const session::Session again = SessionOf(scene, trial, what_if.line, best.alternative, settings);
  EXPECT_EQ(RunTrial(scene, again, context_).force_hash, best.result.force_hash);
  EXPECT_LT(*ValueOf(best.result.assessment, "tip to target at the end"), 3.0);
}

}  // namespace
}  // namespace acus::trials
