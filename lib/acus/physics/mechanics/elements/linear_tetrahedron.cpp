#include "acus/physics/mechanics/elements/linear_tetrahedron.h"

#include <cmath>

#include "acus/base/core/error.h"
#include "acus/data/mesh/quality.h"

namespace acus::mechanics {

LinearTetrahedron LinearTetrahedronOf(const mesh::TetraMesh& mesh, int tetrahedron) {
  const mesh::Corners corners = mesh::CornersOf(mesh, tetrahedron);
  Eigen::Matrix3d edges;
  double longest_mm = 0.0;
  for (int c = 0; c < 3; ++c) {
    edges.col(c) = corners[c + 1] - corners[0];
    for (int b = 0; b <= c; ++b) {
      longest_mm = std::max(longest_mm, (corners[c + 1] - corners[b]).norm());
    }
  }
  LinearTetrahedron element;
  element.volume_mm3 = edges.determinant() / 6.0;
  if (!(element.volume_mm3 > 1e-12 * longest_mm * longest_mm * longest_mm)) {
    const Eigen::Vector3d at = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
    throw InputError(Message("tetrahedron ", tetrahedron, " of the mesh, about (", at.x(), ", ",
                             at.y(), ", ", at.z(), ") mm, is inside out or flat: its volume is ",
                             element.volume_mm3, " mm^3; mesh it again with acus-mesh"));
  }
  element.gradients_per_mm.rightCols<3>() = edges.inverse().transpose();
  element.gradients_per_mm.col(0) = -element.gradients_per_mm.rightCols<3>().rowwise().sum();
  return element;
}

TetrahedronMatrix DeviatoricStiffness(const LinearTetrahedron& element, double shear_modulus_mpa) {
  const Eigen::Matrix<double, 3, 4>& g = element.gradients_per_mm;
  const double scale = element.volume_mm3 * shear_modulus_mpa;
  TetrahedronMatrix k;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      // 2 dev(eps) : dev(eps) of g_i (x) e_a with g_j (x) e_b.
      k.block<3, 3>(3 * i, 3 * j) =
          scale * (g.col(i).dot(g.col(j)) * Eigen::Matrix3d::Identity() +
                   g.col(j) * g.col(i).transpose() - 2.0 / 3.0 * g.col(i) * g.col(j).transpose());
    }
  }
  return k;
}

Eigen::Matrix<double, 12, 1> VolumeGradientMm2(const LinearTetrahedron& element) {
  const Eigen::Matrix<double, 3, 4> b = element.volume_mm3 * element.gradients_per_mm;
  return Eigen::Map<const Eigen::Matrix<double, 12, 1>>(b.data());
}

}  // namespace acus::mechanics
