// A patient's breath from a belt or a tracked marker on the skin, at any moment between readings.
#pragma once

#include <cstdint>

#include "acus/data/session/signals.h"
#include "acus/physics/breathing/breath.h"

namespace acus::live {

/// Follows readings of the level by an alpha-beta filter, which gives the rate as well. When
/// readings stop, it goes on at the last rate for kPredictS, slows down over kSlowS and then holds,
/// so that tissue neither jumps nor runs away. Pure; allocates nothing.
class BeltFollower {
 public:
  static constexpr double kFreshS = 0.1;      ///< Readings may be this old without a remark.
  static constexpr double kPredictS = 0.3;    ///< Goes on at the last rate for so long ...
  static constexpr double kSlowS = 0.5;       ///< ... and to a standstill in this time.
  static constexpr double kMostLevel = 10.0;  ///< Levels beyond it are not a breath.

  /// A reading, in terms of a normal breath. Those not later than the last one, not finite or not a
  /// breath are left out and counted.
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

/// How far through a breath somebody is whose level and its sign of change are known: as in a
/// sinusoid from 1 at end inspiration to 0 half way. [0, 1).
double CycleOf(double level, double level_per_s) noexcept;

}  // namespace acus::live
