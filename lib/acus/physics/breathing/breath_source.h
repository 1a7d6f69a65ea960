// The breath of a session: a recording or a pattern, which the patient may be asked to hold.
#pragma once

#include <variant>
#include <vector>

#include "acus/physics/breathing/breathing_pattern.h"
#include "acus/physics/breathing/recorded_breath.h"

namespace acus::breathing {

/// From `begin_s` to `end_s` the patient holds his breath.
struct BreathHold {
  double begin_s = 0.0;
  double end_s = 0.0;
};

/// Time of breath, which stands still while breath is held. It slows down and picks up again over
/// kRampS, so that what depends on the signal's rate does not jump.
class BreathClock {
 public:
  static constexpr double kRampS = 0.5;

  /// @throws InputError if holds overlap, are not in order, or are shorter than two ramps.
  explicit BreathClock(std::vector<BreathHold> holds);

  struct Moment {
    double time_s = 0.0;
    double speed = 1.0;  ///< d time / d session time, 0 to 1.
  };
  Moment At(double session_s) const noexcept;

 private:
  std::vector<BreathHold> holds_;
};

class BreathSource {
 public:
  using Signal = std::variant<BreathingPattern, RecordedBreath>;
  BreathSource(Signal signal, std::vector<BreathHold> holds)
      : signal_(std::move(signal)), clock_(std::move(holds)) {}

  /// @param session_s  Since the session began. Allocates nothing.
  Breath At(double session_s) const noexcept;

  const Signal& signal() const { return signal_; }

 private:
  Signal signal_;
  BreathClock clock_;
};

}  // namespace acus::breathing
