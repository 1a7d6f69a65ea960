// A straight ray in the world, bent into the patient at rest.
#pragma once

#include <Eigen/Core>

#include "acus/physics/breathing/motion_map.h"

namespace acus::volume_rendering {

struct WarpSettings {
  /// At most this many per sample, eq. 2 of Fortmeier-2016, from the sample before ...
  int max_iterations = 5;
  /// ... and no more than needed for steps shorter than this.
  double tolerance_mm = 0.05;
  /// Where |X + u(X) - x| stays below this between the corners of a block of about 6 mm, samples in
  /// it take what lies between those (WarpLattice). 0: every sample inverts for itself.
  double lattice_mm = 0.15;
};

/// Follows one ray from sample to sample: X <- x - u(X), from the sample before it moved on by the
/// step (Fortmeier-2016, eq. 1-2). Where that does not converge within the tolerance, steps are
/// halved as in math::InvertDisplacement.
class WarpedRay {
 public:
  WarpedRay(const breathing::MotionMap& motion, const WarpSettings& settings)
      : motion_(motion), settings_(settings) {}

  /// The tissue that is now at `world_mm`. @param step_mm  From the sample before.
  Eigen::Vector3d RestOf(const Eigen::Vector3d& world_mm, const Eigen::Vector3d& step_mm) noexcept {
    const Eigen::Vector3d start_mm = has_before_ ? Eigen::Vector3d(rest_mm_ + step_mm)
                                                 : Eigen::Vector3d(world_mm - displacement_mm_);
    rest_mm_ = world_mm - motion_.DisplacementMm(start_mm);
    const int allowed = has_before_ ? settings_.max_iterations : kEntryIterations;
    const double missing_mm = (rest_mm_ - start_mm).norm();
    if (allowed > 1 && missing_mm > settings_.tolerance_mm) {
      rest_mm_ =
          motion_
              .RestOf(world_mm, rest_mm_,
                      {.max_iterations = allowed - 1, .tolerance_mm = settings_.tolerance_mm})
              .rest_mm;
    }
    displacement_mm_ = world_mm - rest_mm_;
    has_before_ = true;
    return rest_mm_;
  }

  /// The next sample is not one step away from this one.
  void Jump() noexcept { has_before_ = false; }

 private:
  /// For the first sample after a jump, which has no neighbour.
  static constexpr int kEntryIterations = 20;

  const breathing::MotionMap& motion_;
  WarpSettings settings_;
  bool has_before_ = false;
  Eigen::Vector3d rest_mm_ = Eigen::Vector3d::Zero();          ///< Of the sample before.
  Eigen::Vector3d displacement_mm_ = Eigen::Vector3d::Zero();  ///< Where the last sample was.
};

}  // namespace acus::volume_rendering
