#include "acus/scene/effects/pain_reaction/jerk.h"

#include <cmath>

#include "acus/base/core/error.h"

namespace acus::effects {
namespace {

/// Rises from 0 to 1 as t goes from 0 to 1, with the least integral of the squared jerk.
double MinimumJerk(double t) noexcept {
  return t * t * t * (10.0 + t * (-15.0 + 6.0 * t));
}

}  // namespace

Jerk::Jerk(double latency_s, double rise_s, double return_s)
    : latency_s_(latency_s), rise_s_(rise_s), return_s_(return_s) {
  ACUS_REQUIRE(latency_s >= 0.0 && rise_s > 0.0 && return_s > 0.0 && std::isfinite(DurationS()),
               "a jerk has a latency of ", latency_s, " s, a rise of ", rise_s,
               " s and a return of ", return_s,
               " s; a latency from 0 and durations above 0 are allowed");
}

double Jerk::At(double since_s) const noexcept {
  const double moving_s = since_s - latency_s_;
  if (!(moving_s > 0.0 && since_s < DurationS())) return 0.0;
  return moving_s < rise_s_ ? MinimumJerk(moving_s / rise_s_)
                            : 1.0 - MinimumJerk((moving_s - rise_s_) / return_s_);
}

}  // namespace acus::effects
