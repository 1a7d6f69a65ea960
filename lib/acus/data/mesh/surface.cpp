#include "acus/data/mesh/surface.h"

namespace acus::mesh {

double SignedVolumeMm3(const Surface& surface) {
  double six_volumes = 0.0;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    const Eigen::Vector3d a = surface.nodes_mm.col(surface.triangles(0, t));
    const Eigen::Vector3d b = surface.nodes_mm.col(surface.triangles(1, t));
    const Eigen::Vector3d c = surface.nodes_mm.col(surface.triangles(2, t));
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6.0;
}

}  // namespace acus::mesh
