// Loads on meshes of tetrahedra, and tables of elastic constants, to test mechanics with.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <functional>
#include <vector>

#include "acus/data/mesh/quality.h"
#include "acus/data/mesh/tetra_faces.h"
#include "acus/data/mesh/tetra_mesh.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/mechanics/elements/stiffness.h"

namespace acus::testing_support {

inline constexpr mechanics::ElementKind kBothElements[] = {
    mechanics::ElementKind::kLinear, mechanics::ElementKind::kAveragedDilatation};

/// All tissues from 1 to 255 of one stiffness.
inline mechanics::ElasticityTable UniformTable(double youngs_modulus_mpa, double poissons_ratio) {
  mechanics::ElasticityTable table;
  table.file = "test.json";
  table.tissue.fill({youngs_modulus_mpa, poissons_ratio});
  table.named.set();
  table.named.reset(0);
  return table;
}

using VectorField = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

inline Eigen::Matrix3Xd AtNodes(const mesh::TetraMesh& mesh, const VectorField& field) {
  Eigen::Matrix3Xd out(3, mesh.nodes_mm.cols());
  for (Eigen::Index i = 0; i < out.cols(); ++i) out.col(i) = field(mesh.nodes_mm.col(i));
  return out;
}

/// Fixes all nodes of the outer surface.
inline void FixSurface(mesh::TetraMesh& mesh) {
  mesh.fixed_nodes = mesh::OuterNodes(mesh);
}

/// Nodal forces equal to a traction (MPa) on the outer faces of which all corners fulfil `is_on`.
/// Each face is cut into `cuts`^2 triangles, so that a traction may end within a face.
inline Eigen::Matrix3Xd TractionLoad(const mesh::TetraMesh& mesh,
                                     const std::function<bool(const Eigen::Vector3d&)>& is_on,
                                     const VectorField& traction_mpa, int cuts = 1) {
  Eigen::Matrix3Xd force = Eigen::Matrix3Xd::Zero(3, mesh.nodes_mm.cols());
  const auto faces = mesh::SortedFaces(mesh);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const bool is_inner = (f > 0 && faces[f - 1].IsSameFace(faces[f])) ||
                          (f + 1 < faces.size() && faces[f + 1].IsSameFace(faces[f]));
    std::array<Eigen::Vector3d, 3> x;
    bool all_on = true;
    for (int c = 0; c < 3; ++c) {
      x[c] = mesh.nodes_mm.col(faces[f].nodes[c]);
      all_on = all_on && is_on(x[c]);
    }
    if (is_inner || !all_on) continue;
    const double area = 0.5 * (x[1] - x[0]).cross(x[2] - x[0]).norm() / (cuts * cuts);
    for (int i = 0; i < cuts; ++i) {
      for (int j = 0; i + j < cuts; ++j) {
        for (int down = 0; down < (i + j + 1 < cuts ? 2 : 1); ++down) {
          const double shift = down ? 2.0 / 3.0 : 1.0 / 3.0;
          const Eigen::Vector3d w(1.0 - (i + j + 2 * shift) / cuts, (i + shift) / cuts,
                                  (j + shift) / cuts);
          const Eigen::Vector3d t = traction_mpa(w[0] * x[0] + w[1] * x[1] + w[2] * x[2]);
          for (int c = 0; c < 3; ++c) force.col(faces[f].nodes[c]) += area * w[c] * t;
        }
      }
    }
  }
  return force;
}

/// Calls visit(tetrahedron, place, weights of the corners, volume) at four points of each
/// tetrahedron that integrate quadratics.
template <typename Visit>
void ForEachQuadraturePoint(const mesh::TetraMesh& mesh, const Visit& visit) {
  constexpr double kFar = 0.13819660112501052;
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    const mesh::Corners corners = mesh::CornersOf(mesh, t);
    const double volume_mm3 = mesh::VolumeMm3(corners) / 4.0;
    for (int q = 0; q < 4; ++q) {
      Eigen::Vector4d w = Eigen::Vector4d::Constant(kFar);
      w[q] = 1.0 - 3.0 * kFar;
      Eigen::Vector3d x = Eigen::Vector3d::Zero();
      for (int c = 0; c < 4; ++c) x += w[c] * corners[c];
      visit(t, x, w, volume_mm3);
    }
  }
}

/// Nodal forces equal to a force per volume (N/mm^3).
inline Eigen::Matrix3Xd BodyLoad(const mesh::TetraMesh& mesh, const VectorField& density) {
  Eigen::Matrix3Xd force = Eigen::Matrix3Xd::Zero(3, mesh.nodes_mm.cols());
  ForEachQuadraturePoint(mesh, [&](Eigen::Index t, const Eigen::Vector3d& x,
                                   const Eigen::Vector4d& w, double volume_mm3) {
    const Eigen::Vector3d f = volume_mm3 * density(x);
    for (int c = 0; c < 4; ++c) force.col(mesh.tetrahedra(c, t)) += w[c] * f;
  });
  return force;
}

/// Root of the integral of |u - exact|^2, over that of |exact|^2.
inline double RelativeL2Error(const mesh::TetraMesh& mesh, const Eigen::Matrix3Xd& u,
                              const VectorField& exact) {
  double error = 0.0;
  double size = 0.0;
  ForEachQuadraturePoint(mesh, [&](Eigen::Index t, const Eigen::Vector3d& x,
                                   const Eigen::Vector4d& w, double volume_mm3) {
    Eigen::Vector3d here = Eigen::Vector3d::Zero();
    for (int c = 0; c < 4; ++c) here += w[c] * u.col(mesh.tetrahedra(c, t));
    error += volume_mm3 * (here - exact(x)).squaredNorm();
    size += volume_mm3 * exact(x).squaredNorm();
  });
  return std::sqrt(error / size);
}

}  // namespace acus::testing_support
