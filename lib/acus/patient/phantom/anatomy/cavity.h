// What slides when a patient breathes: everything within ribs and abdominal wall.
#pragma once

#include <span>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/phantom/anatomy/smooth_level.h"

namespace acus::phantom {

/// Height of the diaphragm by place: where the lung begins, smoothed by a Gaussian of 15 mm and a
/// cubic B-spline; where no lung is above it, that of its surroundings. CT mm, LPS.
class DiaphragmHeight {
 public:
  DiaphragmHeight() = default;
  /// @param lowest_mm  By column of a grid of `spacing_mm` that begins at `first_mm`, x fastest;
  ///     NaN: unknown.  @param otherwise_mm  Far from every column that is known.
  DiaphragmHeight(const Eigen::Vector2d& first_mm, double spacing_mm, Eigen::Array2i size,
                  std::span<const double> lowest_mm, double otherwise_mm);

  double AtMm(double x_mm, double y_mm) const noexcept;

 private:
  Eigen::Vector2d first_mm_ = Eigen::Vector2d::Zero();
  double spacing_mm_ = 1.0;
  Eigen::Array2i size_ = {1, 1};
  std::vector<double> height_mm_ = {0.0};
};

/// The space within the pleura and the peritoneum, and the places that breathing goes by. CT mm,
/// LPS.
struct Cavity {
  SmoothLevel wall;  ///< < 0 in the cavity. Runs on beyond the volume's lower border.
  DiaphragmHeight diaphragm;
  double dome_z_mm = 0.0;    ///< Height of the diaphragm's domes.
  double top_z_mm = 0.0;     ///< Of the lungs; 160 mm above the domes where the volume cuts them.
  double middle_x_mm = 0.0;  ///< Of the body.
  double spine_front_mm = 0.0;  ///< y of the front of the spine at the height of the domes.
  double skin_front_mm = 0.0;   ///< y of the skin in front, the foremost.
  double lung_front_mm = 0.0;   ///< y that 1 % of the lung is in front of.
  double lung_back_mm = 0.0;    ///< y that 1 % of the lung is behind.
};

/// Finds the wall on rays from the middle of the trunk, in every slice: behind the lung; in front
/// of ribs, sternum and spine; where there is neither, 12 mm under the subcutaneous fat in front
/// and from its surroundings elsewhere. Bone stays outside.
/// @param labels  In standard labels, with bone and, for the diaphragm, lung.
/// @throws InputError if there is no bone, no body, or no lung.
Cavity FindCavity(const volume::LabelMap& labels, const RunContext& context);

/// On the grid of its wall: 1, "cavity", within it.
volume::LabelMap LabelsOf(const Cavity& cavity);

}  // namespace acus::phantom
