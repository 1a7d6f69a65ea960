// The settings of acus-rf: configs/rf/<name>.json (format acus-rf/1).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/imaging/rf/beamform.h"
#include "acus/imaging/rf/channel_simulator.h"

namespace acus::rf {

/// Where a MATLAB file of another laboratory has what the settings need.
struct RecordingNames {
  std::string variable;     ///< Of the channel data; empty: the first numeric array.
  std::string sampling_hz;  ///< Of the sampling rate; empty: that of the settings.
  std::string start_s;      ///< Of the time of the first sample; empty: that of the settings.
  std::vector<int> transmissions;  ///< Of the file's, from 0, that the settings have; empty: all.
  bool is_bandpass_sampled = false;
};

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
  RecordingNames recording;
};

/// @param variable  Instead of the settings' if it is not empty.
/// @throws InputError if the file does not hold what the settings name.
ChannelData ReadRecording(const std::filesystem::path& path, const RfSettings& settings,
                          const std::string& variable);

/// @throws InputError listing all problems of the file, or naming the value that is out of range.
RfSettings ReadRfSettings(const std::filesystem::path& path);

}  // namespace acus::rf
