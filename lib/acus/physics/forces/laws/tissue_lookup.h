// The tissue at a place: from a label map, or from the HU of the CT where there is none.
#pragma once

#include <Eigen/Geometry>

#include "acus/data/volume/volume.h"
#include "acus/physics/forces/laws/hu_field.h"
#include "acus/physics/forces/models/model_settings.h"

namespace acus::forces {

/// A plain value that refers to what it looks in, which must outlive it.
class TissueLookup {
 public:
  explicit TissueLookup(const volume::LabelMap& labels)
      : labels_(&labels),
        index_from_ct_(labels.geometry.index_from_ct()),
        half_voxel_mm_(0.5 * labels.geometry.spacing_mm.minCoeff()) {}
  TissueLookup(const HuField& field, const HuTissues& tissues)
      : field_(&field), tissues_(&tissues), half_voxel_mm_(0.5 * field.ResolutionMm()) {}

  /// 0 outside the body, outside the volume and for a place that is not finite.
  volume::Label At(const Eigen::Vector3d& place_in_ct_mm) const noexcept;

  /// Half the smallest length of a voxel: how close to look so as to meet every one of them, mm.
  double HalfVoxelMm() const noexcept { return half_voxel_mm_; }

 private:
  const volume::LabelMap* labels_ = nullptr;
  const HuField* field_ = nullptr;
  const HuTissues* tissues_ = nullptr;
  Eigen::Affine3d index_from_ct_ = Eigen::Affine3d::Identity();
  double half_voxel_mm_;
};

}  // namespace acus::forces
