// The settings of deformable tissue in a scenario.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace acus::scenario {

enum class TissueModelKind { kDisplacementFunctions, kSprings, kPlane2010, kFem3d };

/// Tissue that tools deform. Only the settings of its model are read.
struct TissueEffect {
  TissueModelKind model = TissueModelKind::kDisplacementFunctions;
  std::filesystem::path elasticity;
  std::filesystem::path table;    ///< Force table, for models that touch the needle.
  bool image = true;              ///< The images show the deformation.
  bool pressed_by_probe = false;  ///< ... and the skin under the probe; not fe_3d.
  double warp_spacing_mm = 0.0;
  int inverse_iterations = 0;
  double influence_radius_mm = 0.0;  ///< displacement_functions, springs.
  bool printed_form = false;         ///< displacement_functions: the formulas exactly as printed.
  double tip_length_mm = 0.0;        ///< displacement_functions; 0: that of the form.
  double path_spacing_mm = 0.0;      ///< springs.
  double plane_spacing_mm = 0.0;     ///< This and the other members of the plane: fe_2d.
  double plane_width_mm = 0.0;
  int plane_turned = 0;
  bool plane_full_update = false;  ///< All of the inverse changes with each node.
  double plane_beyond_mm = 0.0;
  double plane_thickness_mm = 0.0;
  std::string element;              ///< fe_3d: the element with which acus-mesh condensed the mesh.
  double contact_spacing_mm = 0.0;  ///< fe_3d.
  bool probe_contact = false;       ///< fe_3d.
  bool finite_strain = false;       ///< fe_3d: tissue near the corridor stiffens.
  int strain_nodes = 0;             ///< fe_3d with finite strain, as the next.
  int strain_iterations = 0;        ///< Iterations per step.

  /// True if the model runs at every step and computes the force on the needle itself.
  bool TouchesNeedle() const { return model != TissueModelKind::kDisplacementFunctions; }
};

/// @param settings  /effects/tissue, checked against the schema.
/// @param folder  The base of relative paths.
TissueEffect ReadTissueEffect(const nlohmann::json& settings, const std::filesystem::path& folder);

}  // namespace acus::scenario
