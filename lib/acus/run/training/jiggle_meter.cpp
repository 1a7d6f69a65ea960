#include "acus/run/training/jiggle_meter.h"

#include <algorithm>

namespace acus::training {

void JiggleMeter::Axis::Add(std::int64_t time_ns, double place_mm) {
  if (!begun) {
    begun = true;
    low_mm = high_mm = place_mm;
  }
  low_mm = std::min(low_mm, place_mm);
  high_mm = std::max(high_mm, place_mm);
  const bool rose = place_mm - low_mm >= kAmplitudeMm && direction <= 0;
  const bool fell = high_mm - place_mm >= kAmplitudeMm && direction >= 0;
  if (!rose && !fell) return;
  if (direction != 0) {  // The first stroke is no turn.
    std::rotate(turn_ns.begin(), turn_ns.begin() + 1, turn_ns.end());
    turn_ns.back() = time_ns;
    turns = std::min(turns + 1, kTurns);
  }
  direction = rose ? 1 : -1;
  low_mm = high_mm = place_mm;
}

bool JiggleMeter::Axis::TurnedWithin(std::int64_t time_ns) const {
  return turns == kTurns && time_ns - turn_ns.front() <= kWithinNs;
}

void JiggleMeter::Add(std::int64_t time_ns, const Eigen::Vector3d& tip_mm) {
  jiggled_ = false;
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    axes_[a].Add(time_ns, tip_mm[static_cast<Eigen::Index>(a)]);
    jiggled_ = jiggled_ || axes_[a].TurnedWithin(time_ns);
  }
}

}  // namespace acus::training
