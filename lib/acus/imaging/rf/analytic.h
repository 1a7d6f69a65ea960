// Channel data as complex baseband: what delay and sum interpolates.
#pragma once

#include <complex>
#include <span>
#include <vector>

#include "acus/imaging/rf/channel_data.h"

namespace acus::rf {

/// The analytic signal of every trace (its positive frequencies, doubled, without its mean), times
/// exp(-2 pi i f t): its magnitude is the envelope of the trace.
struct Baseband {
  int samples = 0;  ///< Of each trace.
  int elements = 0;
  int transmits = 0;
  double sampling_mhz = 0.0;
  double start_us = 0.0;
  double carrier_mhz = 0.0;  ///< f, which the samples were lowered by.
  std::vector<std::complex<float>> values;

  const std::complex<float>* Trace(int transmit, int element) const {
    return values.data() + (static_cast<std::size_t>(transmit) * elements + element) * samples;
  }
};

/// @param oversampling  Samples of the baseband for each of the data, 1 to 16: band-limited
///     interpolation, so that linear interpolation in between is enough.
/// @param carrier_mhz  About the centre of the band.
/// @throws InputError if the carrier is not below half the sampling rate or, of data that are
///     bandpass sampled, within a tenth of that of one of its multiples.
Baseband BasebandOf(const ChannelData& data, double carrier_mhz, int oversampling, int num_threads);

}  // namespace acus::rf
