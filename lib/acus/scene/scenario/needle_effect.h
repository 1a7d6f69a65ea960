// The settings of the needle's shape in a scenario.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace acus::scenario {

enum class NeedleModelKind { kRigid, kLateralBeam, kBendable };

/// The needle's shape, and the force across its path.
struct NeedleEffect {
  NeedleModelKind model = NeedleModelKind::kRigid;
  bool axis_lock = false;            ///< rigid, lateral_beam: shown on its path once punctured.
  std::filesystem::path elasticity;  ///< bendable, as the following members.
  double influence_radius_mm = 20.0;
  int nodes = 25;
  double path_spacing_mm = 1.0;
  double tip_stiffness_n_per_mm = 0.5;
  double hand_n_per_mm = 0.5;
  double hand_n_mm_per_rad = 500.0;
  double kappa_n_per_mm = 0.5;
  bool hand_has_potential = true;  ///< False: the springs of the hand as printed.
  bool bevel = true;               ///< The needle's bevel steers.
};

/// @param settings  /effects/needle, checked against the schema.
/// @param folder  The base of relative paths.
NeedleEffect ReadNeedleEffect(const nlohmann::json& settings, const std::filesystem::path& folder);

}  // namespace acus::scenario
