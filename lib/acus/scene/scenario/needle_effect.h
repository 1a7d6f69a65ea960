// The needle's shape, as a scenario calls for it.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace acus::scenario {

enum class NeedleModelKind { kRigid, kLateralBeam, kBendable };

/// The needle's shape, and what it does across its path.
struct NeedleEffect {
  NeedleModelKind model = NeedleModelKind::kRigid;
  bool axis_lock = false;            ///< rigid, lateral_beam: once punctured, shown on its path.
  std::filesystem::path elasticity;  ///< bendable, as all that follows.
  double influence_radius_mm = 20.0;
  int nodes = 25;
  double path_spacing_mm = 1.0;
  double tip_stiffness_n_per_mm = 0.5;
  double hand_n_per_mm = 0.5;
  double hand_n_mm_per_rad = 500.0;
  double kappa_n_per_mm = 0.5;
  bool bevel = true;  ///< The needle's bevel steers.
};

/// @param settings  /effects/needle, checked against the schema.
/// @param folder  What paths are relative to.
NeedleEffect ReadNeedleEffect(const nlohmann::json& settings, const std::filesystem::path& folder);

}  // namespace acus::scenario
