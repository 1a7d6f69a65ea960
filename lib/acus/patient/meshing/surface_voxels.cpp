#include "acus/patient/meshing/surface_voxels.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace acus::meshing {
namespace {

struct Crossing {
  double x_mm;
  int turn;  ///< +1 into the surface, -1 out of it.
};

/// Where the line along x through (y, z) crosses the triangle, if it does.
bool Cross(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, double y,
           double z, Crossing& out) {
  const auto area = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
    return (p[1] - y) * (q[2] - z) - (p[2] - z) * (q[1] - y);
  };
  const double wa = area(b, c);
  const double wb = area(c, a);
  const double wc = area(a, b);
  const double sum = wa + wb + wc;
  if (sum == 0.0 || (wa < 0) != (sum < 0) || (wb < 0) != (sum < 0) || (wc < 0) != (sum < 0)) {
    return false;
  }
  out.x_mm = (wa * a[0] + wb * b[0] + wc * c[0]) / sum;
  out.turn = sum < 0 ? 1 : -1;  // The outward normal looks along -x where the line goes in.
  return true;
}

}  // namespace

volume::LabelMap VoxelsInside(const mesh::Surface& surface, double spacing_mm,
                              volume::Label label) {
  const Eigen::Vector3d low = surface.nodes_mm.rowwise().minCoeff();
  const Eigen::Vector3d extent = surface.nodes_mm.rowwise().maxCoeff() - low;
  volume::Geometry g;
  double voxels = 1.0;
  for (int d = 0; d < 3; ++d) voxels *= std::ceil(extent[d] / spacing_mm) + 3.0;
  ACUS_REQUIRE(voxels < 4e8, "a surface of ", extent.maxCoeff(), " mm in voxels of ", spacing_mm,
               " mm would be too large; choose a larger element size");
  for (int d = 0; d < 3; ++d) g.size[d] = static_cast<int>(std::ceil(extent[d] / spacing_mm)) + 3;
  g.spacing_mm.setConstant(spacing_mm);
  // Odd shares of a voxel, so that lines do not run through nodes of tidy surfaces.
  g.origin_mm = low - spacing_mm * Eigen::Vector3d(1.0, 0.731, 0.617);
  volume::LabelMap out(g);
  std::vector<std::vector<Crossing>> lines(static_cast<std::size_t>(g.size[1]) * g.size[2]);
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    Eigen::Matrix3d x;
    for (int c = 0; c < 3; ++c)
      x.col(c) = surface.nodes_mm.col(surface.triangles(c, t)) - g.origin_mm;
    const Eigen::Vector3d from = x.rowwise().minCoeff() / spacing_mm;
    const Eigen::Vector3d to = x.rowwise().maxCoeff() / spacing_mm;
    for (int k = static_cast<int>(std::ceil(from[2])); k <= to[2]; ++k) {
      for (int j = static_cast<int>(std::ceil(from[1])); j <= to[1]; ++j) {
        Crossing crossing{};
        if (Cross(x.col(0), x.col(1), x.col(2), j * spacing_mm, k * spacing_mm, crossing)) {
          lines[static_cast<std::size_t>(k) * g.size[1] + j].push_back(crossing);
        }
      }
    }
  }
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      auto& line = lines[static_cast<std::size_t>(k) * g.size[1] + j];
      std::ranges::sort(line, {}, &Crossing::x_mm);
      int winding = 0;
      std::size_t next = 0;
      for (int i = 0; i < g.size[0]; ++i) {
        for (; next < line.size() && line[next].x_mm <= i * spacing_mm; ++next)
          winding += line[next].turn;
        if (winding != 0) out.At(i, j, k) = label;
      }
    }
  }
  return out;
}

}  // namespace acus::meshing
