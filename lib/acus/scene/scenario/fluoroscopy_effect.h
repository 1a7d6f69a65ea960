// The fluoroscopy of a scenario: which C-arm, where it stands, how often it looks.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>

namespace acus::scenario {

struct FluoroscopyEffect {
  std::filesystem::path c_arm;                        ///< C-arm preset.
  std::optional<Eigen::Vector3d> isocentre_in_ct_mm;  ///< Nothing: the middle of the CT.
  double lao_rad = 0.0;                               ///< Negative: RAO.
  double cranial_rad = 0.0;                           ///< Negative: caudal.
  double rate_hz = 0.0;
  bool needle = true;
};

/// @param effect  /effects/fluoroscopy, checked against the schema.
/// @param folder  What paths are relative to.
FluoroscopyEffect ReadFluoroscopyEffect(const nlohmann::json& effect,
                                        const std::filesystem::path& folder);

}  // namespace acus::scenario
