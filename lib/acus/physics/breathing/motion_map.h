// The patient at one moment of breath: from the reference image to the world and back.
#pragma once

#include <Eigen/Geometry>

#include "acus/base/math/inverse_map.h"
#include "acus/physics/breathing/motion_model.h"

namespace acus::breathing {

/// Maps between rest (the reference image) and world (the patient as he breathes), both in CT
/// space. Cheap to make at every step; keeps a reference to the field.
class MotionMap {
 public:
  MotionMap(const MotionField& field, const MotionWeights& weights)
      : field_(&field), weights_(weights) {}

  /// False: world and rest are the same, and every map returns its argument bit for bit.
  bool moves() const noexcept { return weights_.count > 0; }

  const MotionField& field() const { return *field_; }
  const MotionWeights& weights() const { return weights_; }

  Eigen::Vector3d DisplacementMm(const Eigen::Vector3d& rest_mm) const noexcept {
    return field_->DisplacementMm(weights_, rest_mm);
  }
  Eigen::Vector3d WorldMm(const Eigen::Vector3d& rest_mm) const noexcept {
    return moves() ? Eigen::Vector3d(rest_mm + DisplacementMm(rest_mm)) : rest_mm;
  }

  /// The tissue that is now at `world_mm`. Fixed point from `start_mm`: where the same place was
  /// at rest a step before, or what a neighbour gave (Fortmeier-2016, sections 2.1 and 2.2).
  /// Bounded, and never non-finite, also where the field folds: see math::InvertDisplacement.
  math::InversePoint RestOf(const Eigen::Vector3d& world_mm, const Eigen::Vector3d& start_mm,
                            const math::InverseSettings& settings) const noexcept;

  /// d world / d rest, eq. 3, from differences over 2 mm. The identity where nothing moves.
  Eigen::Matrix3d GradientAt(const Eigen::Vector3d& rest_mm) const noexcept;

 private:
  const MotionField* field_;
  MotionWeights weights_;
};

/// The rotation nearest to a deformation gradient; the identity if there is none (a determinant
/// that is not positive).
Eigen::Matrix3d RotationOf(const Eigen::Matrix3d& gradient) noexcept;

}  // namespace acus::breathing
