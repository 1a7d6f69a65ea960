// Echoes of points after many lengths of path, sampled finely.
#pragma once

#include <complex>
#include <span>
#include <vector>

#include "acus/imaging/rf/pulse.h"

namespace acus::rf {

/// What the table is made for.
struct PulseTableOptions {
  double sampling_mhz = 20.0;
  double attenuation_db_per_cm_mhz = 0.0;
  double longest_path_mm = 0.0;  ///< Two-way.
  double band_mm = 4.0;          ///< Of path: each band has a pulse of its own.
  int phases = 16;               ///< Delays by fractions of a sample.
  double half_length_us = 0.8;   ///< The pulse is 0 beyond.
};

/// Complex envelopes relative to the carrier: the echo is Re(envelope(t) exp(2 pi i f t)).
/// Each band holds the attenuated spectrum, transformed back.
class PulseTable {
 public:
  PulseTable(const Pulse& pulse, const PulseTableOptions& options);

  int length() const { return length_; }  ///< Samples of an envelope.
  int phases() const { return phases_; }
  double half_length_us() const { return half_length_us_; }
  double carrier_mhz() const { return carrier_mhz_; }

  int BandOf(double path_mm) const;
  double PathOf(int band) const { return (band + 0.5) * band_mm_; }  ///< What the band is made for.
  /// The centre of gravity of the band's amplitude spectrum.
  double FrequencyOf(int band) const { return frequency_mhz_[static_cast<std::size_t>(band)]; }

  /// Sample j is the envelope at (j - phase / phases) / sampling - half_length.
  std::span<const std::complex<float>> Envelope(int band, int phase) const;

 private:
  void FillBand(int band, const Pulse& pulse, const PulseTableOptions& options);

  int phases_;
  int length_;
  double half_length_us_;
  double carrier_mhz_;
  double band_mm_;
  std::vector<double> frequency_mhz_;         ///< By band.
  std::vector<std::complex<float>> samples_;  ///< By band, phase, sample.
};

}  // namespace acus::rf
