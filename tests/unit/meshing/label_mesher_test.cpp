#include "meshing/label_mesher.h"

#include <gmock/gmock.h>
#include <chrono>
#include <iostream>

#include "core/error.h"
#include "mesh/quality.h"

namespace acus::meshing {
namespace {

volume::LabelMap Ball(double radius_mm) {
  volume::Geometry g;
  g.size = {50, 50, 50};
  g.spacing_mm = {1.5, 1.5, 1.5};
  volume::LabelMap out(g);
  out.names = {{1, "soft_tissue"}, {2, "bone"}};
  for (int k = 0; k < 50; ++k)
    for (int j = 0; j < 50; ++j)
      for (int i = 0; i < 50; ++i) {
        const double r = 1.5 * (Eigen::Vector3d(i, j, k) - Eigen::Vector3d::Constant(24.5)).norm();
        if (r < radius_mm) out.At(i, j, k) = 1;
        if (r < radius_mm * 0.5) out.At(i, j, k) = 2;
      }
  return out;
}

TEST(MeshLabelMap, Ball) {
  LabelMeshSettings settings;
  RunContext context;
  settings.min_dihedral_deg = 0;
  const auto start = std::chrono::steady_clock::now();
  const LabelMesh out = MeshLabelMap(Ball(30.0), settings, context);
  const auto q = mesh::MeasureQuality(out.mesh);
  std::cout << std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() << " s " << q.num_nodes << " " << q.num_tetrahedra << " " << q.min_dihedral_deg << " " << q.max_dihedral_deg << " mean " << q.mean_min_dihedral_deg << "\n";
  for (const auto& t : out.tissues) std::cout << t.name << " " << t.map_ml << " " << t.mesh_ml << "\n";
}

}  // namespace
}  // namespace acus::meshing
