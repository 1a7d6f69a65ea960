#include "acus/imaging/rf/pulse_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"

namespace acus::rf {
namespace {

/// A spectrum on an even grid of frequencies.
struct SampledSpectrum {
  double first_mhz = 0.0;
  double step_mhz = 0.0;
  std::vector<double> values;  ///< Amplitudes.

  double FrequencyAt(std::size_t k) const { return first_mhz + static_cast<double>(k) * step_mhz; }
};

SampledSpectrum Sample(const Pulse& pulse, const PulseTableOptions& options, double path_mm) {
  const double b = NeperPerMhz(options.attenuation_db_per_cm_mhz, path_mm);
  // As fine as keeps the periods of the sum over frequencies outside the table.
  const double step_mhz = 0.25 / options.half_length_us;
  SampledSpectrum out{step_mhz, step_mhz, {}};
  const double last_mhz = pulse.frequency_mhz + 5.0 * pulse.SigmaMhz();
  for (double f = step_mhz; f <= last_mhz; f += step_mhz) {
    out.values.push_back(pulse.SpectrumAt(f) * std::exp(-b * f));
  }
  return out;
}

/// Centre frequency of the amplitudes.
double CentreOf(const SampledSpectrum& spectrum) {
  double sum = 0.0;
  double moment = 0.0;
  for (std::size_t k = 0; k < spectrum.values.size(); ++k) {
    sum += std::abs(spectrum.values[k]);
    moment += std::abs(spectrum.values[k]) * spectrum.FrequencyAt(k);
  }
  return sum > 0.0 ? moment / sum : 0.0;
}

std::complex<double> EnvelopeAt(const SampledSpectrum& spectrum, double carrier_mhz,
                                double time_us) {
  std::complex<double> sum = 0.0;
  for (std::size_t k = 0; k < spectrum.values.size(); ++k) {
    const double turn = 2.0 * std::numbers::pi * (spectrum.FrequencyAt(k) - carrier_mhz) * time_us;
    sum += spectrum.values[k] * std::polar(1.0, turn);
  }
  return sum;
}

}  // namespace

PulseTable::PulseTable(const Pulse& pulse, const PulseTableOptions& options)
    : phases_(options.phases),
      length_(static_cast<int>(std::ceil(2.0 * options.half_length_us * options.sampling_mhz)) + 2),
      half_length_us_(options.half_length_us),
      carrier_mhz_(pulse.frequency_mhz),
      band_mm_(options.band_mm) {
  ACUS_ASSERT(phases_ >= 1 && band_mm_ > 0.0 && half_length_us_ > 0.0);
  const int bands = static_cast<int>(options.longest_path_mm / band_mm_) + 1;
  frequency_mhz_.resize(static_cast<std::size_t>(bands));
  samples_.resize(static_cast<std::size_t>(bands) * phases_ * length_);
  for (int band = 0; band < bands; ++band) FillBand(band, pulse, options);
}

void PulseTable::FillBand(int band, const Pulse& pulse, const PulseTableOptions& options) {
  const SampledSpectrum spectrum = Sample(pulse, options, PathOf(band));
  frequency_mhz_[static_cast<std::size_t>(band)] = CentreOf(spectrum);
  // 1 at the middle without attenuation.
  double unit = 0.0;
  for (std::size_t k = 0; k < spectrum.values.size(); ++k) {
    unit += pulse.SpectrumAt(spectrum.FrequencyAt(k));
  }
  for (int phase = 0; phase < phases_; ++phase) {
    std::complex<float>* out =
        samples_.data() + (static_cast<std::size_t>(band) * phases_ + phase) * length_;
    for (int j = 0; j < length_; ++j) {
      const double time_us =
          (j - static_cast<double>(phase) / phases_) / options.sampling_mhz - half_length_us_;
      if (std::abs(time_us) > half_length_us_) continue;
      out[j] = std::complex<float>(EnvelopeAt(spectrum, carrier_mhz_, time_us) / unit);
    }
  }
}

int PulseTable::BandOf(double path_mm) const {
  const auto last = static_cast<int>(frequency_mhz_.size()) - 1;
  return std::clamp(static_cast<int>(path_mm / band_mm_), 0, last);
}

std::span<const std::complex<float>> PulseTable::Envelope(int band, int phase) const {
  return {samples_.data() + (static_cast<std::size_t>(band) * phases_ + phase) * length_,
          static_cast<std::size_t>(length_)};
}

}  // namespace acus::rf
