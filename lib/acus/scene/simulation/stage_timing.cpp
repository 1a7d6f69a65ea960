#include "acus/scene/simulation/stage_timing.h"

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/error.h"

namespace acus::simulation {

std::string_view WordsOf(Sleep sleep) {
  switch (sleep) {
    case Sleep::kAwake:
      return "awake";
    case Sleep::kNeedleUnseen:
      return "the tracker has not seen the needle";
    case Sleep::kNeedleOutside:
      return "needle outside the tissue";
    case Sleep::kUntouched:
      return "no tool touches the tissue";
    case Sleep::kProbeUnseen:
      return "the tracker does not see the probe";
    case Sleep::kProbeOffSkin:
      return "probe off the skin";
    case Sleep::kAtRest:
      return "the patient lies as in the CT";
    case Sleep::kUndeformed:
      return "nothing deforms the tissue";
    case Sleep::kNothingMoved:
      return "nothing moved since the last image";
    case Sleep::kNeedleOffPlane:
      return "only the needle moved, far from the image plane";
    case Sleep::kEffectIdle:
      return "the effect has nothing to do";
    case Sleep::kEnd:
      break;
  }
  ACUS_ASSERT(false);
}

void StageTimes::Add(const StageTimes& other) {
  ACUS_ASSERT(cost.size() == other.cost.size());
  for (std::size_t i = 0; i < cost.size(); ++i) {
    cost[i].seconds += other.cost[i].seconds;
    cost[i].runs += other.cost[i].runs;
    cost[i].asleep += other.cost[i].asleep;
    for (std::size_t r = 0; r < cost[i].asleep_for.size(); ++r) {
      cost[i].asleep_for[r] += other.cost[i].asleep_for[r];
    }
  }
}

Stopwatch::Stopwatch(StageTimes* times, int stands_for, clockid_t clock) noexcept
    : times_(times), stands_for_(times != nullptr ? stands_for : 0), clock_(clock) {
  if (stands_for_ > 0) last_s_ = CpuSeconds(clock_);
}

void Stopwatch::EndOf(std::size_t stage, Sleep sleep) noexcept {
  if (times_ == nullptr) return;
  StageTimes::Cost& cost = times_->cost[stage];
  ++cost.runs;
  if (sleep != Sleep::kAwake) {
    ++cost.asleep;
    ++cost.asleep_for[static_cast<std::size_t>(sleep)];
  }
  if (stands_for_ == 0) return;
  const double now_s = CpuSeconds(clock_);
  cost.seconds += stands_for_ * (now_s - last_s_);
  last_s_ = now_s;
}

}  // namespace acus::simulation
