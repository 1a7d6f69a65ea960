// Channel data: what each element of an array receives after each transmission.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace acus::rf {

/// values[(transmit * elements + element) * samples + sample]: in NumPy an array of shape
/// (transmits, elements, samples), in MATLAB one of samples x elements x transmits.
struct ChannelData {
  int samples = 0;
  int elements = 0;
  int transmits = 0;
  double sampling_mhz = 0.0;
  double start_us =
      0.0;  ///< Of the first sample, after the first element of the transmission fires.
  std::vector<float> values;
  /// The band lies between two multiples of half the sampling rate and appears folded below it.
  bool is_bandpass_sampled = false;

  void Allocate() { values.assign(static_cast<std::size_t>(samples) * elements * transmits, 0.0F); }
  std::size_t Offset(int transmit, int element) const {
    return (static_cast<std::size_t>(transmit) * elements + element) * samples;
  }
  std::span<const float> Trace(int transmit, int element) const {
    return {values.data() + Offset(transmit, element), static_cast<std::size_t>(samples)};
  }
  std::span<float> Trace(int transmit, int element) {
    return {values.data() + Offset(transmit, element), static_cast<std::size_t>(samples)};
  }
};

/// The transmissions of these numbers, from 0, in this order; all if there are none.
/// @throws InputError naming a number that the data do not have.
ChannelData WithTransmissions(const ChannelData& data, std::span<const int> numbers);

/// The same data. @throws InputError naming the first value that is not finite, or the size that
/// does not fit; `label` stands for the file in messages.
const ChannelData& Checked(const ChannelData& data, const char* label);

}  // namespace acus::rf
