#include "acus/imaging/rf/rf_settings.h"

#include <cmath>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/math/angles.h"
#include "acus/imaging/rf/matlab_file.h"

namespace acus::rf {
namespace {

using nlohmann::json;

Eigen::Vector2d PairOf(const json& pair) {
  return {pair.at(0).get<double>(), pair.at(1).get<double>()};
}

std::vector<Transmit> TransmitsOf(const json& document) {
  std::vector<Transmit> out;
  for (const json& angle_deg : document.at("plane_waves_deg")) {
    out.push_back({angle_deg.get<double>() * math::kRadPerDegree, {}});
  }
  for (const json& focus_mm : document.at("foci_mm")) out.push_back({0.0, PairOf(focus_mm)});
  return out;
}

ChannelOptions ChannelsOf(const json& document) {
  ChannelOptions out;
  out.sound_speed_mm_per_us = 1e-3 * document.at("sound_speed_m_per_s").get<double>();
  out.attenuation_db_per_cm_mhz = document.at("attenuation_db_per_cm_mhz");
  out.sampling_mhz = document.at("sampling_mhz");
  out.start_us = document.at("start_us");
  out.samples = document.at("samples");
  out.transmit_tail_us = document.at("transmit_tail_us");
  return out;
}

PixelGrid GridOf(const json& image) {
  PixelGrid grid;
  grid.step_mm = PairOf(image.at("step_mm"));
  const Eigen::Vector2d size_mm(image.at("width_mm").get<double>(),
                                image.at("depth_mm").get<double>());
  grid.columns = static_cast<int>(std::floor(size_mm.x() / grid.step_mm.x() + 1e-9)) + 1;
  grid.first_mm = {-0.5 * (grid.columns - 1) * grid.step_mm.x(), image.at("top_mm").get<double>()};
  grid.rows =
      static_cast<int>(std::floor((size_mm.y() - grid.first_mm.y()) / grid.step_mm.y() + 1e-9)) + 1;
  return grid;
}

BeamformOptions BeamformOf(const json& image, double sound_speed_mm_per_us) {
  return {sound_speed_mm_per_us, image.at("f_number").get<double>(),
          image.at("apodisation") == "hann" ? Apodisation::kHann : Apodisation::kRectangular};
}

RecordingNames RecordingOf(const json& recording) {
  return {recording.at("variable"), recording.at("sampling_hz"), recording.at("start_s"),
          recording.at("transmissions").get<std::vector<int>>(), recording.at("bandpass_sampled")};
}

}  // namespace

ChannelData ReadRecording(const std::filesystem::path& path, const RfSettings& settings,
                          const std::string& variable) {
  const RecordingNames& names = settings.recording;
  ChannelData data = WithTransmissions(
      ReadMatlab(path, variable.empty() ? names.variable : variable), names.transmissions);
  data.is_bandpass_sampled = names.is_bandpass_sampled;
  data.sampling_mhz = names.sampling_hz.empty() ? settings.channels.sampling_mhz
                                                : 1e-6 * ReadMatlabNumber(path, names.sampling_hz);
  data.start_us = names.start_s.empty() ? settings.channels.start_us
                                        : 1e6 * ReadMatlabNumber(path, names.start_s);
  ACUS_REQUIRE(
      data.sampling_mhz > 0.0 && std::isfinite(data.sampling_mhz) && std::isfinite(data.start_us),
      path.string(), ": a sampling rate of ", data.sampling_mhz, " MHz and a first sample at ",
      data.start_us,
      " us; /recording/sampling_hz must name a rate above 0, in Hz, start_s a time in s");
  return data;
}

RfSettings ReadRfSettings(const std::filesystem::path& path) {
  const json document = config::ReadConfig(path, "acus-rf");
  RfSettings out;
  out.probe = acoustics::ReadProbe(
      config::FindConfig(document.at("probe").get<std::string>(), path.parent_path()));
  out.array = ArrayOf(out.probe, document.at("element_width_mm"));
  out.pulse = {out.probe.frequency_mhz, out.probe.fractional_bandwidth,
               document.at("burst_cycles")};
  out.transmits = TransmitsOf(document);
  ACUS_REQUIRE(!out.transmits.empty(), path.string(),
               ": has no transmission; add angles to plane_waves_deg or places to foci_mm");
  out.channels = ChannelsOf(document);
  for (const json& point : document.at("points")) {
    out.points.push_back({PairOf(point.at("at_mm")), point.at("amplitude")});
  }
  const json& speckle = document.at("speckle");
  out.speckle = {PairOf(speckle.at("low_mm")), PairOf(speckle.at("high_mm")),
                 speckle.at("per_mm2")};
  const json& image = document.at("image");
  out.grid = GridOf(image);
  ACUS_REQUIRE(out.grid.rows >= 1, path.string(), ": /image/depth_mm: ends above top_mm");
  out.beamform = BeamformOf(image, out.channels.sound_speed_mm_per_us);
  out.baseband_oversampling = image.at("oversampling");
  out.dynamic_range_db = image.at("dynamic_range_db");
  out.recording = RecordingOf(document.at("recording"));
  return out;
}

}  // namespace acus::rf
