// The breath of a live session, step by step: from a belt, or from a training partner who breathes
// as the scenario says; held on command.
#pragma once

#include "acus/data/session/signals.h"
#include "acus/run/live/belt.h"
#include "acus/scene/simulation/breathing_scene.h"

namespace acus::live {

/// One thread. Allocates nothing.
class LiveBreath {
 public:
  /// @param partner  The patient's breath where there is no belt. Must outlive this.
  /// @param has_belt  Breath comes from ReadBelt().
  LiveBreath(const simulation::Breathing& partner, bool has_belt)
      : partner_(partner), has_belt_(has_belt) {}

  /// Takes effect with the next step: breath slows down and picks up again as in BreathClock, over
  /// BreathClock::kRampS.
  void Hold(bool on) noexcept { holds_ = on; }
  bool holds() const noexcept { return holds_; }

  /// Session time, s; level relative to a normal breath.
  void ReadBelt(double time_s, double level) noexcept { belt_.Read(time_s, level); }
  const BeltFollower& belt() const noexcept { return belt_; }

  /// The breath of a step. @param session_s  Since the session began; never decreases.
  session::BreathSample Step(double session_s) noexcept;

 private:
  /// Breath time that passes in `dt_s`, while its speed approaches 0 (hold) or 1.
  double Advance(double dt_s) noexcept;
  breathing::Breath OfBelt(double session_s, double dt_s, double passed_s) noexcept;

  const simulation::Breathing& partner_;
  bool has_belt_;
  BeltFollower belt_;
  bool holds_ = false;
  bool started_ = false;
  double last_s_ = 0.0;
  double breath_s_ = 0.0;  ///< Stands still during a hold.
  double speed_ = 1.0;     ///< d breath_s / d session_s.
  double level_ = 1.0;     ///< Level of the last step, with a belt.
  double offset_ = 0.0;    ///< Difference from the belt's level after a hold.
};

}  // namespace acus::live
