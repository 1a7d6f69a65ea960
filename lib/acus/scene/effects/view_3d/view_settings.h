// Settings of the view of the patient in three dimensions.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace acus::effects {

/// As in the schema under effects/view_3d, which states ranges and defaults.
struct View3dSettings {
  struct Layer {
    std::string preset;
    double opacity = 0.0;
  };
  struct Surface {
    std::string tissue;  ///< "skin": the outer border of all labelled tissue.
    double opacity = 0.0;
    std::optional<Eigen::Array3f> colour;  ///< Nothing: the tissue's standard colour.
  };

  int width_px = 0;
  int height_px = 0;
  std::string from;  ///< A side of the patient, unless there is an eye.
  std::optional<Eigen::Vector3d> eye_in_ct_mm;
  std::optional<Eigen::Vector3d> focus_in_ct_mm;
  Eigen::Vector3d up_in_ct = Eigen::Vector3d::UnitZ();
  double view_angle_deg = 0.0;
  std::filesystem::path camera_path;  ///< Empty: the camera stays.
  bool beside_rest = false;           ///< Two images: at rest, and deformed.
  bool event_stills = true;
  bool maximum_projection = false;                      ///< In place of the layers.
  Eigen::Vector2d window_hu = Eigen::Vector2d::Zero();  ///< Projection: HU at black and at white.
  std::vector<Layer> layers;
  std::vector<Surface> surfaces;
  double surface_grid_mm = 0.0;
  bool needle = true;
  bool probe = true;
  double force_arrow_mm_per_n = 0.0;  ///< 0: none.
  bool pressed = true;                ///< The view shows the tissue pressed by tools.
  bool shadows = true;
  double tool_shine = 0.0;
  int supersampling = 0;
  double step_mm = 0.0;
  int inverse_iterations = 0;
  double warp_tolerance_mm = 0.0;
  double pixel_tolerance = 0.0;
};

/// @param settings  As the schema checked and completed them.
View3dSettings ReadView3dSettings(const nlohmann::json& settings);

}  // namespace acus::effects
