// The spectrum of a point's echo, before and after attenuation.
#pragma once

namespace acus::rf {

/// The pulse of transmission and reception together. The amplitude spectrum is a Gaussian around
/// the centre frequency, times that of a rectangular burst of a sine.
struct Pulse {
  double frequency_mhz = 5.0;
  double fractional_bandwidth = 0.6;  ///< Of the probe: width at half of the amplitude over centre.
  double burst_cycles = 0.0;          ///< Of the excitation; 0: an impulse.

  double SigmaMhz() const;                        ///< Of the Gaussian spectrum.
  double SpectrumAt(double frequency_mhz) const;  ///< 1 at the centre.
};

/// A Gaussian spectrum after a path through tissue.
struct AttenuatedGaussian {
  double frequency_mhz = 0.0;  ///< Centre.
  double gain = 1.0;           ///< At the centre, over that before.
};

/// Attenuation b f nepers over the path, b in Np/MHz, turns exp(-(f - f0)^2 / (2 s^2)) into a
/// Gaussian of the same width around f0 - b s^2, times exp(-b f0 + b^2 s^2 / 2) (Kuc, IEEE TASSP
/// 33(1), 1985).
AttenuatedGaussian AttenuateGaussian(double frequency_mhz, double sigma_mhz, double neper_per_mhz);

/// Nepers per MHz of a path, from the coefficient in dB/(cm MHz).
double NeperPerMhz(double attenuation_db_per_cm_mhz, double path_mm);

}  // namespace acus::rf
