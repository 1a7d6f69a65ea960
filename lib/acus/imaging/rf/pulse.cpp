#include "acus/imaging/rf/pulse.h"

#include <cmath>
#include <numbers>

namespace acus::rf {

double Pulse::SigmaMhz() const {
  return 0.5 * fractional_bandwidth * frequency_mhz / std::sqrt(2.0 * std::numbers::ln2);
}

double Pulse::SpectrumAt(double at_mhz) const {
  const double aside_mhz = at_mhz - frequency_mhz;
  const double x = aside_mhz / SigmaMhz();
  const double u = std::numbers::pi * burst_cycles * aside_mhz / frequency_mhz;
  const double burst = std::abs(u) < 1e-9 ? 1.0 : std::sin(u) / u;
  return std::exp(-0.5 * x * x) * burst;
}

AttenuatedGaussian AttenuateGaussian(double frequency_mhz, double sigma_mhz, double neper_per_mhz) {
  const double shift_mhz = neper_per_mhz * sigma_mhz * sigma_mhz;
  return {frequency_mhz - shift_mhz,
          std::exp(-neper_per_mhz * frequency_mhz + 0.5 * neper_per_mhz * shift_mhz)};
}

double NeperPerMhz(double attenuation_db_per_cm_mhz, double path_mm) {
  return std::numbers::ln10 / 200.0 * attenuation_db_per_cm_mhz * path_mm;
}

}  // namespace acus::rf
