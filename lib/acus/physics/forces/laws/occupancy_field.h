// Tissues of a label map as a field with a surface, where the CT's values do not show it.
#pragma once

#include <bitset>

#include "acus/physics/forces/laws/hu_field.h"

namespace acus::forces {

/// How much of the surrounding of a place is of some tissues: 0 to kFull, smoothed over two voxels
/// so that its surface has no steps; kOutsideHu beyond the volume. Their surface is where it passes
/// kSurface, within half a voxel of that of the labels.
class OccupancyField : public HuField {
 public:
  static constexpr int kFull = 1024;
  static constexpr double kSurface = 0.5 * kFull;

  /// @throws InputError if the label map is empty.
  OccupancyField(const volume::LabelMap& labels, const std::bitset<256>& tissues);
  OccupancyField(const OccupancyField&) = delete;
  OccupancyField& operator=(const OccupancyField&) = delete;

  double HuAt(const Eigen::Vector3d& place_in_ct_mm) const noexcept override {
    return field_.HuAt(place_in_ct_mm);
  }
  double ResolutionMm() const noexcept override { return field_.ResolutionMm(); }

 private:
  volume::CtVolume grid_;
  CtField field_;
};

}  // namespace acus::forces
