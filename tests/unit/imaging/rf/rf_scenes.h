// Small acquisitions for tests.
#pragma once

#include <vector>

#include "acus/imaging/rf/beamform.h"
#include "acus/imaging/rf/channel_simulator.h"

namespace acus::rf {

/// 5 MHz, pitch 0.3 mm.
inline Array RowOf(int count, double pitch_mm = 0.3, double width_mm = 0.25) {
  acoustics::Probe probe;
  probe.kind = acoustics::ProbeKind::kLinear;
  probe.elements = count;
  probe.pitch_mm = pitch_mm;
  probe.width_mm = count * pitch_mm;
  return ArrayOf(probe, width_mm);
}

inline ChannelOptions Lossless(int samples) {
  ChannelOptions options;
  options.attenuation_db_per_cm_mhz = 0.0;
  options.sampling_mhz = 40.0;
  options.samples = samples;
  return options;
}

inline ChannelData Recorded(const Array& array, const std::vector<Transmit>& transmits,
                            const std::vector<Scatterer>& scatterers, const ChannelOptions& options,
                            int threads = 2, const Pulse& pulse = {}) {
  const ChannelSimulator simulator(array, pulse, transmits, options);
  ChannelData data = simulator.Empty();
  simulator.Add(scatterers, threads, data);
  return data;
}

}  // namespace acus::rf
