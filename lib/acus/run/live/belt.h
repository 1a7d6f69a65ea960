// A patient's breath from a belt or a tracked marker on the skin, at any time between readings.
#pragma once

#include <cstdint>

#include "acus/data/session/signals.h"
#include "acus/physics/breathing/breath.h"

namespace acus::live {

/// Follows readings of the level by an alpha-beta filter, which also estimates the rate. When
/// readings stop, it continues at the last rate for kPredictS, slows down over kSlowS and then
/// holds, so that tissue neither jumps nor drifts. Pure; allocates nothing.
class BeltFollower {
 public:
  static constexpr double kFreshS = 0.1;      ///< Readings up to this age count as current.
  static constexpr double kPredictS = 0.3;    ///< Continues at the last rate for this time ...
  static constexpr double kSlowS = 0.5;       ///< ... and comes to rest in this time.
  static constexpr double kMostLevel = 10.0;  ///< Larger levels are no breath.

  /// A reading of the level: 0 at end expiration, 1 at end inspiration of a normal breath. Readings
  /// that are not later than the last one, not finite or above kMostLevel are ignored and counted.
  void Read(double time_s, double level) noexcept;

  /// @param time_s  Not before the last reading.
  breathing::Breath At(double time_s) const noexcept;
  session::BreathStatus StatusAt(double time_s) const noexcept;

  std::int64_t num_readings() const noexcept { return num_readings_; }
  std::int64_t num_rejected() const noexcept { return num_rejected_; }

 private:
  double time_s_ = 0.0;
  double level_ = 1.0;
  double level_per_s_ = 0.0;
  std::int64_t num_readings_ = 0;
  std::int64_t num_rejected_ = 0;
};

/// The phase of a breath with a given level and sign of its rate: that of a sinusoid from 1 at end
/// inspiration to 0 at half the period. [0, 1).
double CycleOf(double level, double level_per_s) noexcept;

}  // namespace acus::live
