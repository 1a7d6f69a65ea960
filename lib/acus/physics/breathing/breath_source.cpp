#include "acus/physics/breathing/breath_source.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::breathing {

BreathClock::BreathClock(std::vector<BreathHold> holds) : holds_(std::move(holds)) {
  for (std::size_t n = 0; n < holds_.size(); ++n) {
    const BreathHold& hold = holds_[n];
    ACUS_REQUIRE(std::isfinite(hold.begin_s) && std::isfinite(hold.end_s) &&
                     hold.end_s - hold.begin_s >= 2.0 * kRampS,
                 "breathing: held from ", hold.begin_s, " to ", hold.end_s,
                 " s; a hold lasts at least ", 2.0 * kRampS, " s");
    ACUS_REQUIRE(n == 0 || hold.begin_s >= holds_[n - 1].end_s, "breathing: held from ",
                 hold.begin_s, " s on, before the hold until ", holds_[n - 1].end_s,
                 " s is over; give holds in order, without overlap");
  }
}

BreathClock::Moment BreathClock::At(double session_s) const noexcept {
  double lost_s = 0.0;
  for (const BreathHold& hold : holds_) {
    if (session_s <= hold.begin_s) break;
    if (session_s >= hold.end_s) {
      lost_s += hold.end_s - hold.begin_s - kRampS;  // Each ramp lets half its length pass.
      continue;
    }
    // The speed falls to 0 linearly, stays, and rises again.
    const double slowing = std::min(session_s - hold.begin_s, kRampS);
    const double rising = std::max(session_s - hold.end_s + kRampS, 0.0);
    return {.time_s = hold.begin_s - lost_s + slowing - 0.5 * slowing * slowing / kRampS +
                      0.5 * rising * rising / kRampS,
            .speed = 1.0 - slowing / kRampS + rising / kRampS};
  }
  return {.time_s = session_s - lost_s, .speed = 1.0};
}

Breath BreathSource::At(double session_s) const noexcept {
  const BreathClock::Moment moment = clock_.At(session_s);
  Breath breath = std::visit([&](const auto& signal) { return signal.At(moment.time_s); }, signal_);
  breath.level_per_s *= moment.speed;
  return breath;
}

}  // namespace acus::breathing
