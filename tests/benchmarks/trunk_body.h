// A trunk of ellipsoids: as a CT for images, and in closed form to hold them against.
#pragma once

#include <Eigen/Dense>
#include <memory>

#include "acus/data/volume/volume.h"
#include "acus/physics/breathing/motion_field.h"

namespace acus::benchmarks {

/// Soft tissue of 40 HU in fat of -90 HU, a backbone and eight pairs of ribs' stand-ins (ellipsoids
/// of 700 HU); around it air. In LPS, the middle is the origin.
struct TrunkBody {
  /// 384 x 300 x 300 mm, `per_axis` voxels along each axis; a voxel is the mean over itself, so
  /// that edges are where they are in closed form.
  static std::shared_ptr<volume::CtVolume> Ct(int per_axis);

  /// Integral of (1 + HU / 1000) along a straight line, mm of water: exact.
  static double WaterMm(const Eigen::Vector3d& from_in_ct_mm, const Eigen::Vector3d& to_in_ct_mm);

  /// Breath: the upper part down by 18 mm, with strains up to some 0.3.
  static Eigen::Vector3d BreathMm(const Eigen::Vector3d& rest_mm);
  /// With more components than one, the others are a tenth of it, along other axes.
  static breathing::MotionField Breath(int nodes_per_axis, int num_components = 1);
};

}  // namespace acus::benchmarks
