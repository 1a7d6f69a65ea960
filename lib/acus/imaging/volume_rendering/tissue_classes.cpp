#include "acus/imaging/volume_rendering/tissue_classes.h"

#include "acus/data/volume/label_lookup.h"

namespace acus::volume_rendering {

TissueClasses::TissueClasses(const volume::Geometry& ct, const volume::LabelMap& labels,
                             const ClassOfLabel& class_of)
    : size_(ct.size), classes_(ct.num_voxels()) {
  if (labels.geometry.Matches(ct)) {
    for (std::size_t n = 0; n < classes_.size(); ++n) classes_[n] = class_of[labels.voxels[n]];
    return;
  }
  const Eigen::Affine3d index_from_index = labels.geometry.index_from_ct() * ct.ct_from_index();
  std::size_t n = 0;
  for (int k = 0; k < size_[2]; ++k) {
    for (int j = 0; j < size_[1]; ++j) {
      for (int i = 0; i < size_[0]; ++i, ++n) {
        classes_[n] = class_of[volume::LabelAt(labels, index_from_index, Eigen::Vector3d(i, j, k))];
      }
    }
  }
}

TissueClasses::Set TissueClasses::In(const Eigen::Array3i& low,
                                     const Eigen::Array3i& high) const noexcept {
  if (classes_.empty()) return 1;
  Set out = 0;
  for (int k = low[2]; k <= high[2]; ++k) {
    for (int j = low[1]; j <= high[1]; ++j) {
      const std::size_t row = (static_cast<std::size_t>(k) * static_cast<std::size_t>(size_[1]) +
                               static_cast<std::size_t>(j)) *
                              static_cast<std::size_t>(size_[0]);
      for (int i = low[0]; i <= high[0]; ++i) {
        out |= Set{1} << classes_[row + static_cast<std::size_t>(i)];
      }
    }
  }
  return out;
}

}  // namespace acus::volume_rendering
