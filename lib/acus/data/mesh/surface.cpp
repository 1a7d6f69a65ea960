#include "acus/data/mesh/surface.h"

#include <vector>

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

Surface WithoutUnusedNodes(const Surface& surface) {
  std::vector<int> number(static_cast<std::size_t>(surface.nodes_mm.cols()), -1);
  Surface out;
  out.triangles.resize(3, surface.triangles.cols());
  out.nodes_mm.resize(3, surface.nodes_mm.cols());
  int used = 0;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    for (int c = 0; c < 3; ++c) {
      int& n = number[static_cast<std::size_t>(surface.triangles(c, t))];
      if (n < 0) {
        n = used++;
        out.nodes_mm.col(n) = surface.nodes_mm.col(surface.triangles(c, t));
      }
      out.triangles(c, t) = n;
    }
  }
  out.nodes_mm.conservativeResize(3, used);
  return out;
}

}  // namespace acus::mesh
