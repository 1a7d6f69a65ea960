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
/// `oversampling` times as long.
std::vector<Complex> OneSidedSpectrum(std::span<const float> trace, int oversampling) {
  Eigen::FFT<double> fft;
  const std::vector<Complex> in(trace.begin(), trace.end());
  std::vector<Complex> spectrum;
  fft.fwd(spectrum, in);
  std::vector<Complex> out(trace.size() * static_cast<std::size_t>(oversampling));
  for (std::size_t k = 1; 2 * k < trace.size(); ++k) {
    out[k] = 2.0 * oversampling * spectrum[k];
  }
  return out;
}

void LowerTrace(std::span<const float> trace, double cycles_per_sample, int oversampling,
                std::complex<float>* out) {
  std::vector<Complex> signal;
  Eigen::FFT<double> fft;
  fft.inv(signal, OneSidedSpectrum(trace, oversampling));
  for (std::size_t k = 0; k < signal.size(); ++k) {
    const double cycles = cycles_per_sample * static_cast<double>(k);
    const double phase = -2.0 * std::numbers::pi * (cycles - std::floor(cycles));
    out[k] = std::complex<float>(signal[k] * std::polar(1.0, phase));
  }
}

}  // namespace

Baseband BasebandOf(const ChannelData& data, double carrier_mhz, int oversampling,
                    int num_threads) {
  Checked(data, "channel data");
  ACUS_REQUIRE(oversampling >= 1 && oversampling <= 16, "baseband: the oversampling is ",
               oversampling, "; it must be between 1 and 16");
  ACUS_REQUIRE(carrier_mhz > 0.0 && 2.0 * carrier_mhz < data.sampling_mhz,
               "baseband: the centre frequency is ", carrier_mhz,
               " MHz; it must be above 0 and below half the sampling rate of ", data.sampling_mhz,
               " MHz");
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
    LowerTrace(data.Trace(transmit, element), carrier_mhz / out.sampling_mhz, oversampling,
               out.values.data() + static_cast<std::size_t>(i) * out.samples);
  });
  return out;
}

}  // namespace acus::rf
