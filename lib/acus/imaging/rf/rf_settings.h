// The settings of acus-rf: configs/rf/<name>.json (format acus-rf/1).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/imaging/rf/beamform.h"
#include "acus/imaging/rf/channel_simulator.h"

namespace acus::rf {

/// An acquisition, what lies in front of the probe, and the image that is made of it.
struct RfSettings {
  acoustics::Probe probe;
  Array array;
  Pulse pulse;
  std::vector<Transmit> transmits;
  ChannelOptions channels;
  std::vector<Scatterer> points;
  ScatteringRegion speckle;  ///< density 0: none.
  PixelGrid grid;
  BeamformOptions beamform;
  int baseband_oversampling = 4;
  double dynamic_range_db = 60.0;
};

/// @throws InputError listing all problems of the file, or naming the value that is out of range.
RfSettings ReadRfSettings(const std::filesystem::path& path);

}  // namespace acus::rf
