#include "forces/tissue_lookup.h"

namespace acus::forces {

volume::Label TissueLookup::At(const Eigen::Vector3d& place_in_ct_mm) const noexcept {
  if (labels_ == nullptr) return tissues_->At(field_->HuAt(place_in_ct_mm));
  const Eigen::Array3d index = (index_from_ct_ * place_in_ct_mm).array() + 0.5;
  const Eigen::Array3d size = labels_->geometry.size.cast<double>();
  // Written so that NaN fails it.
  if (!((index >= 0.0).all() && (index < size).all())) return 0;
  return labels_->At(static_cast<int>(index[0]), static_cast<int>(index[1]),
                     static_cast<int>(index[2]));
}

}  // namespace acus::forces
