// Rays that the speed of sound bends, over the whole aperture: what a scanner that assumes straight
// rays shows where, and how much of its focus remains.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/beam_bend.h"
#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/ultrasound/aperture/aperture_rays.h"
#include "acus/imaging/ultrasound/beams/beam_path.h"
#include "acus/imaging/ultrasound/beams/speed_volume.h"

namespace acus::ultrasound {

/// From the face, rays of each direction of ApertureRays are followed through the image plane:
///   dr/dT = v / n^2,  dv/dT = grad n / n,
/// with T the optical length that the scanner takes for depth and n = c0 / c, smoothed over one
/// cell of a raster. A place of the image is then seen at places r_d of the tissue, one per
/// direction d. With the aperture's weights w_d, and the two-way Gaussian
/// K_de = exp(-(x_d - x_e)^2 / (4 sigma^2)) of their distance across the beam, sigma that of the
/// point spread,
///   G^2 = sum_d w_d sum_e w_e K_de,   r = sum_d w_d r_d sum_e w_e K_de / G^2:
/// the share of the two-way intensity that remains, and the place that is seen. Equal places give
/// G = 1. Rays that end in bone have no part in either. Within the plane only.
class Refraction final : public slicing::RestMap {
 public:
  /// Keeps references to `rows` and `rays`.
  /// @param rows  Rows of tissue, along the scan lines.
  Refraction(SpeedVolume speed, const volume::Geometry& geometry, const acoustics::Probe& probe,
             const acoustics::ScanGrid& rows, const ApertureRays& rays);

  /// Follows all rays. The same results with any number of threads.
  /// @param rest  Where the tissue was at rest; null: it has not moved. Used until the next call.
  void Trace(const Eigen::Isometry3d& ct_from_probe, const slicing::RestMap* rest, int num_threads);

  /// gain[line] = G at a row of tissue: two-way amplitude.
  void GainRow(int row, float* gain) const;

  /// From a place of the image to the tissue that is seen there, mm in the image plane (x along the
  /// face, y away from it), at a line and a row. Bilinear between knots.
  Eigen::Vector2d ShiftMm(double line, double row) const;

  /// Tissue at rest that is seen at a place of the image, both in CT space.
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                             const Eigen::Vector3d& guess_in_ct_mm) const noexcept override;
  double SpacingMm() const noexcept override;

 private:
  /// Between four knots, or rays.
  struct Cell {
    std::size_t at;  ///< Of the lower row.
    std::size_t below;
    float across;
    float along;
  };

  void FillRaster(int num_threads);
  Eigen::Array4f At(const Eigen::Array2f& place_mm) const;
  void FollowRays(int direction);
  void CombineRow(int knot_row);
  Cell CellAt(double line, double row) const;
  Eigen::Array2d LineAndRowOf(double x_mm, double y_mm) const;

  SpeedVolume speed_;
  const acoustics::ScanGrid& rows_;
  const ApertureRays& rays_;
  bool fan_;
  double radius_mm_;
  double line_;                   ///< Of neighbouring lines: mm, or rad of a fan.
  std::vector<double> sigma_mm_;  ///< Of the point spread, by knot row.
  // Raster: 1 / n^2, and the gradient of ln n per mm.
  acoustics::ScanGrid columns_;
  BeamPath raster_path_;
  Eigen::Array2f raster_first_mm_;
  float raster_mm_;
  int raster_x_;
  int raster_y_;
  std::vector<float> index_;
  std::vector<float> smooth_;
  std::vector<Eigen::Array4f> raster_;
  // Knots: every so many lines and rows.
  int knot_lines_;
  int knot_rows_;
  int rows_per_knot_;
  double lines_per_knot_;
  std::vector<Eigen::Array2f> bend_mm_;  ///< Of rays: by direction, row, start.
  std::vector<float> left_;              ///< Energy of rays, likewise: bone ends them.
  std::vector<Eigen::Array2f> shift_mm_;
  std::vector<float> component_mm_;
  std::vector<float> gain_;
  // State of the image that is being rendered.
  Eigen::Isometry3d ct_from_probe_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d probe_from_ct_ = Eigen::Isometry3d::Identity();
  const slicing::RestMap* rest_ = nullptr;
};

}  // namespace acus::ultrasound
