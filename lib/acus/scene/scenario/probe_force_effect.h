// The force on the probe or a fingertip, as a scenario calls for it.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace acus::scenario {

enum class ProbeForceModelKind { kVidal, kMultiProxy, kTissue };

/// Forces on the probe or on a fingertip. Only the settings of its model are read.
struct ProbeForceEffect {
  ProbeForceModelKind model = ProbeForceModelKind::kVidal;
  std::filesystem::path table;
  double press_mm = 0.0;      ///< Deeper along the beam than recorded.
  bool reads_labels = false;  ///< multi_proxy, as all that follow. False: the CT.
  bool is_fingertip = false;  ///< False: the face of the probe preset.
  int num_proxies = 0;
  double face_width_mm = 0.0;  ///< Of a probe, across the image plane.
  double fingertip_radius_mm = 0.0;
  bool presses_images = false;  ///< Images show the tissue that the proxies press in.

  /// True if it depends on what the probe looks like.
  bool NeedsProbePreset() const {
    return model == ProbeForceModelKind::kMultiProxy && !is_fingertip;
  }
};

/// @param settings  /effects/probe_force, checked against the schema.
/// @param folder  What paths are relative to.
ProbeForceEffect ReadProbeForce(const nlohmann::json& settings,
                                const std::filesystem::path& folder);

}  // namespace acus::scenario
