// Hounsfield units at a place, for models that go by the CT itself and not by labels.
#pragma once

#include <Eigen/Geometry>

#include "acus/data/volume/volume.h"

namespace acus::forces {

/// Read in the step: implementations allocate nothing, lock nothing and give the same bits for the
/// same place.
class HuField {
 public:
  static constexpr double kOutsideHu = -1024.0;

  virtual ~HuField() = default;
  virtual double HuAt(const Eigen::Vector3d& place_in_ct_mm) const noexcept = 0;
  /// Length over which the field can change much: step of searches and differences, > 0.
  virtual double ResolutionMm() const noexcept = 0;

  /// Central differences over `reach_mm` to each side, but no less than a resolution length, HU/mm.
  Eigen::Vector3d GradientHuPerMm(const Eigen::Vector3d& place_in_ct_mm,
                                  double reach_mm = 0.0) const noexcept;

  /// The first place on the line from `from` to `to` where the field comes from below to `hu`, as a
  /// share of the line; above 1 if there is none. Steps of half a resolution length (longer on ways
  /// over 64 of them), then bisection. 0 if it is at or above `hu` already at `from`.
  double FirstCrossing(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                       double hu) const noexcept;
};

/// A CT, interpolated linearly along the three axes; kOutsideHu beyond its outermost voxel centres
/// by more than half a voxel.
class CtField : public HuField {
 public:
  /// Keeps a reference to `ct`, which must outlive this. @throws InputError if it is empty.
  explicit CtField(const volume::CtVolume& ct);

  double HuAt(const Eigen::Vector3d& place_in_ct_mm) const noexcept override;
  double ResolutionMm() const noexcept override { return resolution_mm_; }

 private:
  const volume::CtVolume& ct_;
  Eigen::Affine3d index_from_ct_;
  double resolution_mm_;
};

}  // namespace acus::forces
