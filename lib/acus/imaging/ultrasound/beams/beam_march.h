// Lines that are not straight: samples at their time of flight, and bent by Snell's law.
#pragma once

#include <Eigen/Core>

#include "acus/imaging/slicing/kernels.h"
#include "acus/imaging/ultrasound/beams/beam_path.h"

namespace acus::ultrasound {

/// Direction of sound behind an interface: n x d keeps its ratio to the speed (Snell).
/// @param direction    Unit, of the sound.
/// @param normal       Unit, either way.
/// @param speed_ratio  c2 / c1.
/// @return unit; `direction` beyond the critical angle, where nothing continues.
Eigen::Vector3d Refracted(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal,
                          double speed_ratio);

/// State of a block of lines that is followed sample by sample. With the straight line's place
/// x(s) = start + s step of BeamPath: place = x(travelled) + shift, and from sample to sample
///   travelled += c / c0,  shift += turn c / c0,
/// c the local speed of sound and c0 what the scanner assumes.
class BeamMarch {
 public:
  static constexpr int kLanes = 64;

  void Start();

  /// Places of the current sample. @pre lanes <= kLanes.
  void Place(const BeamPath& path, const Eigen::Matrix3f& lattice_from_index, int first, int lanes);
  /// The current sample is at s = 0, one sample further is s = 1.
  slicing::kernels::Lines Voxels() const { return LinesOf(voxel_place_, voxel_step_); }
  slicing::kernels::Lines Lattice() const { return LinesOf(lattice_place_, lattice_step_); }

  /// To the next sample. `speed_ratio`: c / c0 of each lane.
  void Advance(const float* speed_ratio, int lanes);

  /// Bends the line of a lane as if `samples_ago` it had met an interface.
  void Bend(int lane, const Eigen::Vector3d& normal, const Eigen::Array3d& spacing_mm,
            double speed_ratio, double samples_ago);

  /// Whether the lane has passed this sample of its straight line since the sample before.
  bool Passed(int lane, float straight_sample) const {
    return before_[lane] < straight_sample && straight_sample <= travelled_[lane];
  }

 private:
  using Rows = float[3][kLanes];
  static slicing::kernels::Lines LinesOf(const Rows& place, const Rows& step) {
    return {{place[0], place[1], place[2]}, {step[0], step[1], step[2]}};
  }

  alignas(64) float travelled_[kLanes];
  alignas(64) float before_[kLanes];
  alignas(64) Rows shift_;
  alignas(64) Rows turn_;
  alignas(64) Rows voxel_place_;
  alignas(64) Rows voxel_step_;  ///< Of the bent line, without the local speed.
  alignas(64) Rows lattice_place_;
  alignas(64) Rows lattice_step_;
};

}  // namespace acus::ultrasound
