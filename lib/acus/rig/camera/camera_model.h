// How a video camera maps points before it to its image: a pinhole and a lens.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace acus::camera {

/// The numbers of the model of Brown (1971), as most calibrations give them:
///   x = X/Z, y = Y/Z, r^2 = x^2 + y^2, s = 1 + k1 r^2 + k2 r^4 + k3 r^6,
///   x' = s x + 2 p1 x y + p2 (r^2 + 2 x^2),  y' = s y + p1 (r^2 + 2 y^2) + 2 p2 x y,
///   column = fx x' + cx,  row = fy y' + cy.
struct CameraParameters {
  std::string name = "camera";
  std::string description;
  int width_px = 0;
  int height_px = 0;
  Eigen::Vector2d focal_px = Eigen::Vector2d::Zero();   ///< fx, fy.
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< cx, cy: where Z meets the image.
  std::array<double, 3> radial{};                       ///< k1, k2, k3.
  std::array<double, 2> tangential{};                   ///< p1, p2.
  std::optional<double> reprojection_rms_px;            ///< Of its calibration, if there was one.
};

/// The camera's frame has x to the right, y down, z forward (mm); centres of pixels are at whole
/// numbers: as volume_rendering::Camera has it, so that a rendered image of `Pinhole()` lies over
/// the video without the distortion of its lens.
class CameraModel {
 public:
  /// @throws InputError unless the size is 16 to 8192 pixels each way, the focal lengths are
  ///     positive, the centre is in the image, all is finite, and every pixel of the image has
  ///     a line of sight: a lens that folds the image is refused.
  explicit CameraModel(CameraParameters parameters);

  /// Column and row. Nothing for a point less than 1 mm before the camera or so far to the side
  /// that the polynomial of the lens turns back: there it would fold into the image.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point_in_camera_mm) const noexcept;
  /// The same, with its derivative by the point, pixels per mm.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point_in_camera_mm,
                                         Eigen::Matrix<double, 2, 3>& derivative) const noexcept;
  /// Line of sight of a pixel, (x, y, 1): the inverse of Project to 1e-9 px. Nothing where no point
  /// projects to.
  std::optional<Eigen::Vector3d> Ray(const Eigen::Vector2d& pixel) const noexcept;
  /// Within the image, by at least `margin_px` from the outermost pixels' centres.
  bool Contains(const Eigen::Vector2d& pixel, double margin_px = 0.0) const noexcept;

  bool has_distortion() const { return has_distortion_; }
  /// The same camera without its lens.
  CameraModel Pinhole() const;
  /// Angle over the width of the image, degrees, without the lens.
  double HorizontalAngleDeg() const;
  const CameraParameters& parameters() const { return parameters_; }

 private:
  Eigen::Vector2d Distort(const Eigen::Vector2d& slope, Eigen::Matrix2d* derivative) const noexcept;

  CameraParameters parameters_;
  bool has_distortion_ = false;
  double largest_radius_ = 0.0;  ///< Of r, within which s r grows.
};

/// A file of format acus-camera/1. @throws InputError as ReadConfig and CameraModel do.
CameraModel ReadCamera(const std::filesystem::path& path);
/// The same from a document that is part of another file. @param where  Named in messages.
CameraModel CameraOf(const nlohmann::json& document, const std::string& where);
/// JSON of format acus-camera/1.
nlohmann::json ToJson(const CameraModel& camera);
void WriteCamera(const std::filesystem::path& path, const CameraModel& camera);

}  // namespace acus::camera
