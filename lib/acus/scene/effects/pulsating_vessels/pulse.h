// The cardiac cycle as a waveform of a vessel wall's motion.
#pragma once

namespace acus::effects {

/// Displacement of a wall, from 0 at the end of diastole to 1 at the peak of systole: half a cosine
/// up, an exponential run-off down. Continuous and periodic.
class Pulse {
 public:
  /// @throws InputError if the rate is outside (0, 300] beats a minute or the share of the cycle
  ///     that the rise takes outside (0, 1).
  Pulse(double beats_per_min, double rise_share);

  double period_s() const { return period_s_; }
  /// @param session_s  Any finite time; for another, the end of diastole.
  double At(double session_s) const noexcept;

 private:
  double period_s_;
  double rise_share_;
};

}  // namespace acus::effects
