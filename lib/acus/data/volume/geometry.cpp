#include "acus/data/volume/geometry.h"

namespace acus::volume {

Eigen::Affine3d Geometry::ct_from_index() const {
  Eigen::Affine3d out = Eigen::Affine3d::Identity();
  out.linear() = direction * spacing_mm.matrix().asDiagonal();
  out.translation() = origin_mm;
  return out;
}

Eigen::Affine3d Geometry::index_from_ct() const {
  return ct_from_index().inverse(Eigen::Affine);
}

bool Geometry::Matches(const Geometry& other, double tolerance_mm) const {
  if ((size != other.size).any()) return false;
  const Eigen::Affine3d a = ct_from_index();
  const Eigen::Affine3d b = other.ct_from_index();
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d index((corner & 1) ? size[0] - 1 : 0, (corner & 2) ? size[1] - 1 : 0,
                                (corner & 4) ? size[2] - 1 : 0);
    if ((a * index - b * index).norm() > tolerance_mm) return false;
  }
  return true;
}

}  // namespace acus::volume
