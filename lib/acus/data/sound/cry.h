// A short cry, as of a person in pain: a voiced "ah" from pulses of the glottis and three
// resonances of the mouth (Klatt, Journal of the Acoustical Society of America 67:971, 1980).
// docs/models/pain_reaction.md
#pragma once

#include <array>

#include "acus/data/sound/sound.h"

namespace acus::sound {

/// A resonance of the mouth.
struct Formant {
  double frequency_hz = 0.0;
  double width_hz = 0.0;  ///< Where its power has fallen to a half.
};

struct CrySettings {
  int rate_hz = 44100;
  double duration_s = 0.6;
  double peak = 0.7;  ///< Of full scale.
  /// Pitch at the beginning, at a third of the duration, and at the end; straight in between.
  std::array<double, 3> pitch_hz = {190.0, 310.0, 150.0};
  /// Frequencies of "ah" (Klatt 1980, table II).
  std::array<Formant, 3> formants = {{{700.0, 130.0}, {1220.0, 70.0}, {2600.0, 160.0}}};
};

/// The same samples for the same settings.
Sound Cry(const CrySettings& settings = {});

/// The pitch at a time. Hz.
double PitchAt(const CrySettings& settings, double time_s);

/// Klatt's resonator, equations 1 and 2: y(n) = A x(n) + B y(n-1) + C y(n-2), of gain 1 at 0 Hz.
class Resonator {
 public:
  Resonator(const Formant& formant, int rate_hz);
  double Next(double x) {
    const double y = a_ * x + b_ * last_ + c_ * before_;
    before_ = last_;
    last_ = y;
    return y;
  }

 private:
  double a_, b_, c_;
  double last_ = 0.0;
  double before_ = 0.0;
};

}  // namespace acus::sound
