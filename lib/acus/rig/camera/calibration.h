// A camera's model from images of a calibration board.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/rig/camera/board_views.h"
#include "acus/rig/camera/camera_model.h"

namespace acus::camera {

struct CalibrationView {
  std::string file;
  int corners = 0;
  int misread = 0;           ///< Omitted markers: BoardView.
  double rms_px = 0.0;       ///< Of its corners' residuals; 0 if it was not used.
  double tilt_deg = 0.0;     ///< Between the board's normal and the camera's axis.
  double distance_mm = 0.0;  ///< Of the board's middle.
  std::string rejected;      ///< Why it was not used; empty if it was.
};

struct CalibrationSettings {
  int least_views = 6;
  int least_corners = 12;  ///< Of a view.
  double limit_px = 3.0;   ///< Larger reprojection errors (RMS) are no calibration.
  bool fit_k3 = false;  ///< Needed for wide lenses only; makes the corners of the image less sure.
};

struct Calibration {
  CameraModel camera;
  double rms_px = 0.0;
  /// Standard deviations of fx, fy, cx, cy (px), k1, k2, k3, p1, p2.
  std::array<double, 9> sigma{};
  std::vector<CalibrationView> views;  ///< In the order of the files.
  double covered_share = 0.0;          ///< Of 8 x 6 fields of the image, those with a corner.
  std::vector<std::string> warnings;
};

/// Zhang's method (2000, doi:10.1109/34.888718) by OpenCV on the corners of all images. Views
/// whose residuals are over three times the median (and over 0.3 px) are omitted, once; before
/// that corners that are over five times the median of all from where the first model, with its
/// distortion, puts them (and over 1 px).
/// @throws InputError if a file cannot be read. @throws NoAnswerError if too few views are left,
///     the markers do not lie as on the board, or residuals are above limit_px: the message says
///     why.
Calibration CalibrateCamera(const std::vector<std::filesystem::path>& images,
                            const CalibrationBoard& board, const CalibrationSettings& settings,
                            const RunContext& context);

/// For the terminal, and of format acus-camera-calibration/1.
std::string TableText(const Calibration& calibration);
nlohmann::json ToJson(const Calibration& calibration);
/// Writes camera.json, calibration.json and provenance.json into an existing folder.
void WriteResult(const std::filesystem::path& folder, const Calibration& calibration,
                 const RunContext& context);

}  // namespace acus::camera
