// The movement of a patient who jerks away from pain, over time.
#pragma once

namespace acus::effects {

/// A movement away and back, each of minimum jerk: position, velocity and acceleration are
/// continuous. Flash and Hogan, J. Neuroscience 5:1688, 1985. docs/models/pain_reaction.md.
class Jerk {
 public:
  /// @throws InputError if a duration is not above 0 or the latency below 0, or one is not finite.
  Jerk(double latency_s, double rise_s, double return_s);

  /// The share of the full movement, from 0 to 1 and back. @param since_s  Time since the pain;
  /// negative or not finite: 0.
  double At(double since_s) const noexcept;
  /// Time from the pain until the patient lies still again.
  double DurationS() const noexcept { return latency_s_ + rise_s_ + return_s_; }

 private:
  double latency_s_;
  double rise_s_;
  double return_s_;
};

}  // namespace acus::effects
