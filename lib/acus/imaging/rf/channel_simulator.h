// Channel data of points: every element transmits, every element receives.
#pragma once

#include <vector>

#include "acus/imaging/rf/array.h"
#include "acus/imaging/rf/channel_data.h"
#include "acus/imaging/rf/pulse_table.h"
#include "acus/imaging/rf/scatterers.h"
#include "acus/imaging/rf/transmit.h"

namespace acus::rf {

/// How echoes are recorded and computed.
struct ChannelOptions {
  double sound_speed_mm_per_us = 1.54;
  double attenuation_db_per_cm_mhz = 0.5;
  double sampling_mhz = 20.0;
  double start_us = 0.0;
  int samples = 2688;
  /// Echoes of transmitting elements that arrive later than the first one by more than this are
  /// omitted, by a raised cosine from half of it on: waves from the edges of the aperture. Shorter
  /// is faster.
  double transmit_tail_us = 2.0;
  int phases = 16;             ///< Of PulseTable, and of the delay of reception.
  double pulse_half_us = 1.2;  ///< The pulse is cut beyond.
};

/// Linear acoustics in the image plane, no multiple scattering, no dispersion: each element has
/// Directivity() at the centre frequency of the echo, and amplitudes fall with 1/r (not below 0.1
/// mm) two-way. Attenuation acts on the spectrum by bands of path, on the rest of a path by
/// its gain at the centre frequency. Each pulse is 1 high at 1 mm from a transmitting element.
class ChannelSimulator {
 public:
  /// @throws InputError if a value is not finite or out of range.
  ChannelSimulator(Array array, const Pulse& pulse, std::vector<Transmit> transmits,
                   const ChannelOptions& options);

  /// Adds the echoes of scatterers to `data`, the same bits with any number of threads.
  /// @pre `data` is as Empty() returns it.
  /// @throws InputError naming the first scatterer that is not finite.
  void Add(const std::vector<Scatterer>& scatterers, int num_threads, ChannelData& data) const;

  ChannelData Empty() const;

 private:
  Array array_;
  Pulse pulse_;
  std::vector<Transmit> transmits_;
  ChannelOptions options_;
};

}  // namespace acus::rf
