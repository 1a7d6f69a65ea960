#include "acus/data/sound/cry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace acus::sound {
namespace {

constexpr double kPi = std::numbers::pi;
// Shares of a period in which the glottis opens and closes.
constexpr double kOpens = 0.40;
constexpr double kCloses = 0.16;

/// Air through the glottis over a period, 0 to 1 (Rosenberg, pulse B; Journal of the Acoustical
/// Society of America 49:583, 1971). @param phase  [0, 1)
double Flow(double phase) {
  if (phase < kOpens) {
    const double x = phase / kOpens;
    return x * x * (3.0 - 2.0 * x);
  }
  if (phase < kOpens + kCloses) {
    const double x = (phase - kOpens) / kCloses;
    return 1.0 - x * x;
  }
  return 0.0;
}

/// Rises within a tenth of the duration and fades over its last half.
double Loudness(double share) {
  const double rise = std::min(1.0, share / 0.1);
  const double fall = std::min(1.0, (1.0 - share) / 0.5);
  return std::sin(0.5 * kPi * rise) * std::sin(0.5 * kPi * fall);
}

}  // namespace

Resonator::Resonator(const Formant& formant, int rate_hz) {
  const double period_s = 1.0 / rate_hz;
  c_ = -std::exp(-2.0 * kPi * formant.width_hz * period_s);
  b_ = 2.0 * std::exp(-kPi * formant.width_hz * period_s) *
       std::cos(2.0 * kPi * formant.frequency_hz * period_s);
  a_ = 1.0 - b_ - c_;
}

double PitchAt(const CrySettings& settings, double time_s) {
  const double share = std::clamp(time_s / settings.duration_s, 0.0, 1.0);
  const auto& pitch_hz = settings.pitch_hz;
  return share < 1.0 / 3.0 ? std::lerp(pitch_hz[0], pitch_hz[1], 3.0 * share)
                           : std::lerp(pitch_hz[1], pitch_hz[2], 1.5 * share - 0.5);
}

Sound Cry(const CrySettings& settings) {
  const auto count = static_cast<std::size_t>(std::llround(settings.duration_s * settings.rate_hz));
  std::vector<Resonator> mouth;
  for (const Formant& formant : settings.formants) mouth.emplace_back(formant, settings.rate_hz);
  std::vector<double> wave(count);
  double phase = 0.0;
  double last_flow = 0.0;
  double largest = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double time_s = static_cast<double>(i) / settings.rate_hz;
    const double flow = Flow(phase);
    double sample = flow - last_flow;  // The lips radiate changes.
    last_flow = flow;
    for (Resonator& formant : mouth) sample = formant.Next(sample);
    wave[i] = sample * Loudness(time_s / settings.duration_s);
    largest = std::max(largest, std::abs(wave[i]));
    phase += PitchAt(settings, time_s) / settings.rate_hz;
    phase -= std::floor(phase);
  }
  Sound sound{.rate_hz = settings.rate_hz, .samples = std::vector<std::int16_t>(count)};
  for (std::size_t i = 0; i < count && largest > 0.0; ++i) {
    sound.samples[i] =
        static_cast<std::int16_t>(std::lround(32767.0 * settings.peak * wave[i] / largest));
  }
  return sound;
}

}  // namespace acus::sound
