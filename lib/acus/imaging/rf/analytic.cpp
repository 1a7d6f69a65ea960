#include "acus/imaging/rf/analytic.h"

#include <cmath>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"

namespace acus::rf {
namespace {

using Complex = std::complex<double>;

/// Positive frequencies of a real trace, doubled and without the mean, in a spectrum that is
/// `oversampling` times as long and repeats beyond its end.
/// @param zone  Number of the multiple of half the sampling rate below the band. Of odd ones the
///     positive frequencies of the trace hold the band mirrored, the negative ones as it is.
std::vector<Complex> OneSidedSpectrum(std::span<const float> trace, int oversampling, int zone) {
  Eigen::FFT<double> fft;
  const std::vector<Complex> in(trace.begin(), trace.end());
  std::vector<Complex> spectrum;
  fft.fwd(spectrum, in);
  std::vector<Complex> out(trace.size() * static_cast<std::size_t>(oversampling));
  const std::size_t length = trace.size();
  const auto whole_turns = static_cast<std::size_t>(zone / 2) * length;
  for (std::size_t k = 1; 2 * k < length; ++k) {
    const std::size_t bin = zone % 2 == 0 ? k : length - k;
    out[(bin + whole_turns) % out.size()] = 2.0 * oversampling * spectrum[bin];
  }
  return out;
}

void LowerTrace(std::span<const float> trace, double cycles_per_sample, int oversampling, int zone,
                std::complex<float>* out) {
  std::vector<Complex> signal;
  Eigen::FFT<double> fft;
  fft.inv(signal, OneSidedSpectrum(trace, oversampling, zone));
  for (std::size_t k = 0; k < signal.size(); ++k) {
    const double cycles = cycles_per_sample * static_cast<double>(k);
    const double phase = -2.0 * std::numbers::pi * (cycles - std::floor(cycles));
    out[k] = std::complex<float>(signal[k] * std::polar(1.0, phase));
  }
}

constexpr double kZoneMargin = 0.1;

/// 0: the band lies below half the sampling rate.
int ZoneOf(const ChannelData& data, double carrier_mhz) {
  const double half_rates = 2.0 * carrier_mhz / data.sampling_mhz;
  if (!data.is_bandpass_sampled) {
    ACUS_REQUIRE(carrier_mhz > 0.0 && half_rates < 1.0, "baseband: the centre frequency is ",
                 carrier_mhz, " MHz; it must be above 0 and below half the sampling rate of ",
                 data.sampling_mhz,
                 " MHz; a band that was recorded folded needs /recording/bandpass_sampled true");
    return 0;
  }
  const double zone = std::floor(half_rates);
  ACUS_REQUIRE(
      half_rates > zone + kZoneMargin && half_rates < zone + 1.0 - kZoneMargin && half_rates < 64.0,
      "baseband: the centre frequency of ", carrier_mhz, " MHz is ", half_rates,
      " times half the sampling rate of ", data.sampling_mhz,
      " MHz; bandpass sampling needs a band between two whole multiples, the centre ", kZoneMargin,
      " away from them, up to 64");
  return static_cast<int>(zone);
}

}  // namespace

Baseband BasebandOf(const ChannelData& data, double carrier_mhz, int oversampling,
                    int num_threads) {
  Checked(data, "channel data");
  ACUS_REQUIRE(oversampling >= 1 && oversampling <= 16, "baseband: the oversampling is ",
               oversampling, "; it must be between 1 and 16");
  const int zone = ZoneOf(data, carrier_mhz);
  Baseband out;
  out.samples = data.samples * oversampling;
  out.elements = data.elements;
  out.transmits = data.transmits;
  out.sampling_mhz = data.sampling_mhz * oversampling;
  out.start_us = data.start_us;
  out.carrier_mhz = carrier_mhz;
  out.values.resize(data.values.size() * static_cast<std::size_t>(oversampling));
  ParallelFor(data.transmits * data.elements, num_threads, [&](int i) {
    const int transmit = i / data.elements;
    const int element = i % data.elements;
    LowerTrace(data.Trace(transmit, element), carrier_mhz / out.sampling_mhz, oversampling, zone,
               out.values.data() + static_cast<std::size_t>(i) * out.samples);
  });
  return out;
}

}  // namespace acus::rf
