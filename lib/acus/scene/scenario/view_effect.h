// The view of the patient in three dimensions that a scenario calls for.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace acus::scenario {

/// As in the schema under effects/view_3d, where ranges and defaults are.
struct View3dEffect {
  struct Layer {
    std::string preset;
    double opacity = 0.0;
  };
  struct Surface {
    std::string tissue;  ///< "skin": the outer border of all that is labelled.
    double opacity = 0.0;
    std::optional<Eigen::Array3f> colour;  ///< Nothing: the standard one of the tissue.
  };

  int width_px = 0;
  int height_px = 0;
  double rate_hz = 0.0;
  std::string from;  ///< A side of the patient, unless there is an eye.
  std::optional<Eigen::Vector3d> eye_in_ct_mm;
  std::optional<Eigen::Vector3d> focus_in_ct_mm;
  Eigen::Vector3d up_in_ct = Eigen::Vector3d::UnitZ();
  double view_angle_deg = 0.0;
  std::vector<Layer> layers;
  std::vector<Surface> surfaces;
  double surface_grid_mm = 0.0;
  bool needle = true;
  bool probe = true;
  bool picture = true;  ///< The B-mode in the probe's plane.
  bool shadows = true;
  double tool_shine = 0.0;
  int supersampling = 0;
  double step_mm = 0.0;
  int inverse_iterations = 0;
  double warp_tolerance_mm = 0.0;

  /// True if the B-mode is shown in the plane of the probe, if there is one.
  bool ShowsPicture() const { return probe && picture; }
};

/// @param effect  /effects/view_3d, checked against the schema.
/// @param where  Names the place in error messages.
/// @throws InputError for an eye without a focus or the other way round, or if nothing is shown.
View3dEffect ReadView3dEffect(const nlohmann::json& effect, const std::string& where);

}  // namespace acus::scenario
