// The knock of a needle on bone: a decaying sinusoid on top of the bone's spring, Alamilla-2021
// eq. 12, held passive by an account of its energy.
#pragma once

namespace acus::forces {

struct HardContactSettings {
  double amplitude_n_s_per_mm = 0.0;  ///< A: newtons per mm/s of impact speed; 0: no knock.
  double duration_s = 0.0;            ///< d: down to 1 % and then off.
  double frequency_hz = 0.0;          ///< f.
  bool without_account =
      false;  ///< As printed: the whole sinusoid, unlimited, also where it pulls.
};

/// A plain value.
struct HardContact {
  bool running = false;
  double impact_mm_per_s = 0.0;  ///< v_in, > 0.
  double elapsed_s = 0.0;
  double account_n_mm = 0.0;  ///< Energy taken from the hand and not yet given back.
  double applied_n = 0.0;     ///< What the last step added.

  /// Begins a knock, unless one is running that is still at least as strong.
  void Strike(const HardContactSettings& settings, double impact_mm_per_s) noexcept;
  void Stop() noexcept { *this = {}; }

  /// The sinusoid at the time that has passed, without the account: A v exp(ln(0.01) t/d) sin(2 pi
  /// f t).
  double NominalN(const HardContactSettings& settings) const noexcept;

  /// One step: books what the last force did over `travel_mm`, then gives the next force.
  ///
  /// The paper calls the knock passive because it is short; a sinusoid in time takes no heed of
  /// where the hand goes and can drive it all the same. Here a force along the motion is only as
  /// large as the account pays for at the present speed.
  /// @param travel_mm   of the device in this step, + inwards.
  /// @param spring_n    the bone's own force, >= 0: the sum with it is held in [0, largest_n].
  /// @return what to add to spring_n, + pushes out.
  double Advance(const HardContactSettings& settings, double travel_mm, double dt_s,
                 double spring_n, double largest_n) noexcept;
};

}  // namespace acus::forces
