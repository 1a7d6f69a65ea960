// The settings of the force on the probe or a fingertip in a scenario.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace acus::scenario {

enum class ProbeForceModelKind { kVidal, kMultiProxy, kTissue };

/// Forces on the probe or on a fingertip. Only the settings of its model are read.
struct ProbeForceEffect {
  ProbeForceModelKind model = ProbeForceModelKind::kVidal;
  std::filesystem::path table;
  double press_mm = 0.0;      ///< Additional depth along the beam, relative to the recording.
  bool reads_labels = false;  ///< multi_proxy, as the following members. False: reads the CT.
  bool is_fingertip = false;  ///< False: the face of the probe preset.
  int num_proxies = 0;
  double face_width_mm = 0.0;  ///< Width of a probe's face, across the image plane.
  double fingertip_radius_mm = 0.0;
  bool presses_images = false;  ///< Images show the tissue that the proxies press in.

  /// True if it depends on the shape of the probe.
  bool NeedsProbePreset() const {
    return model == ProbeForceModelKind::kMultiProxy && !is_fingertip;
  }
};

/// @param settings  /effects/probe_force, checked against the schema.
/// @param folder  The base of relative paths.
ProbeForceEffect ReadProbeForce(const nlohmann::json& settings,
                                const std::filesystem::path& folder);

}  // namespace acus::scenario
