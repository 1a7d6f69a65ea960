// Synthetic breath: regular, or as irregular as requested, and the same for the same seed.
#pragma once

#include <cstdint>
#include <vector>

#include "acus/physics/breathing/breath.h"

namespace acus::breathing {

/// The level falls from 1 at end inspiration to 0 at end expiration and comes back as
/// cos^(2 exponent) of half the cycle's angle (Lujan et al. 1999). Fortmeier-2016 fig. 4a: fixed
/// period; random periods; random speed within a cycle.
struct PatternSettings {
  double period_s = 4.0;
  int exponent = 2;            ///< 1: a sinusoid. More: longer at expiration.
  double period_spread = 0.0;  ///< Standard deviation of periods, as a share.
  double speed_spread = 0.0;   ///< Of the speed within a cycle: largest share faster or slower.
  double level_spread = 0.0;   ///< Standard deviation of the levels at the ends of breaths.
  double level = 1.0;          ///< At end inspiration of the mean breath: 1.5 is a deeper one.
  std::uint64_t seed = 1;
};

class BreathingPattern {
 public:
  /// @throws InputError for a setting out of range.
  explicit BreathingPattern(const PatternSettings& settings);

  /// Smooth in time for all settings: level and its derivative have no step. Before 0 and after 24
  /// hours the breath is held. Allocates nothing; O(log cycles).
  Breath At(double time_s) const noexcept;

  const PatternSettings& settings() const { return settings_; }

 private:
  struct Cycle {
    double start_s;
    double speed_change;  ///< In (-1, 1).
    double high;          ///< Level at its start.
    double low;           ///< Half way.
  };

  PatternSettings settings_;
  std::vector<Cycle> cycles_;  ///< The last one only ends the one before it.
};

}  // namespace acus::breathing
