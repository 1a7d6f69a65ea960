#include "acus/data/volume/label_lookup.h"

namespace acus::volume {

Label LabelAt(const LabelMap& labels, const Eigen::Affine3d& index_from_space,
              const Eigen::Vector3d& point_mm) noexcept {
  const Eigen::Array3d index = (index_from_space * point_mm).array() + 0.5;
  const Eigen::Array3d size = labels.geometry.size.cast<double>();
  // Written so that NaN fails it.
  if (!((index >= 0.0).all() && (index < size).all())) return 0;
  return labels.At(static_cast<int>(index[0]), static_cast<int>(index[1]),
                   static_cast<int>(index[2]));
}

}  // namespace acus::volume
