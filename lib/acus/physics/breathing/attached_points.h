// Points that are attached to the tissue of a patient, such as the nodes of a surface.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "acus/physics/breathing/displacement_kernel.h"
#include "acus/physics/breathing/motion_map.h"

namespace acus::breathing {

/// Moves points, and the normals of their surface, with the breath. At rest they are always at the
/// same places: what a component of the motion is there is looked up once. A moment then is a
/// weighted sum over memory in order, whatever the size of the field (Fortmeier-2016, section 4.4,
/// samples the field for each vertex in each image).
class AttachedPoints {
 public:
  /// @param rest_normals  Unit vectors, as many.
  /// @pre All are finite.
  AttachedPoints(Eigen::Matrix3Xf rest_mm, Eigen::Matrix3Xf rest_normals);

  const Eigen::Matrix3Xf& rest_mm() const { return rest_mm_; }
  const Eigen::Matrix3Xf& rest_normals() const { return rest_normals_; }

  /// World places and normals at a moment, in single precision. Each component is within 1 / 65,000
  /// of its largest value among neighbours. The same bits on every machine, with any number of
  /// threads, whatever moments came before. Allocates where a component is met for the first time.
  /// @pre motion.moves(), and as many columns as there are points.
  void MoveTo(const MotionMap& motion, int num_threads, Eigen::Matrix3Xf& world_mm,
              Eigen::Matrix3Xf& normals);

 private:
  struct Component {
    std::uint64_t field = 0;  ///< MotionField::identity().
    int index = 0;
    std::uint64_t used = 0;  ///< Number of the instant that had it last.
    std::vector<kernels::SurfaceBlock> blocks;
  };
  Component& FindOrLookUp(const MotionField& field, int index, int num_threads);

  Eigen::Matrix3Xf rest_mm_;
  Eigen::Matrix3Xf rest_normals_;
  std::array<Component, MotionWeights::kMaxCount> components_;  ///< As many as a moment may have.
  std::uint64_t moment_ = 0;
};

}  // namespace acus::breathing
