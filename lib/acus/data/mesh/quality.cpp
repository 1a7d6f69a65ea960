#include "acus/data/mesh/quality.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace acus::mesh {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

/// Normals of the faces opposite a, b, c, d, all outwards or all inwards; not normalised.
std::array<Eigen::Vector3d, 4> FaceNormals(const Corners& x) {
  const Eigen::Vector3d ab = x[1] - x[0];
  const Eigen::Vector3d ac = x[2] - x[0];
  const Eigen::Vector3d ad = x[3] - x[0];
  const Eigen::Vector3d bc = x[2] - x[1];
  const Eigen::Vector3d bd = x[3] - x[1];
  return {bc.cross(bd), ad.cross(ac), ab.cross(ad), ac.cross(ab)};
}

/// Cosines of the dihedral angles at ab, ac, ad, bc, bd, cd.
std::array<double, 6> Cosines(const Corners& x) {
  std::array<Eigen::Vector3d, 4> n = FaceNormals(x);
  for (Eigen::Vector3d& normal : n) {
    const double length = std::sqrt(normal.squaredNorm());
    if (length > 0.0) normal /= length;
  }
  // The edge ab belongs to the faces opposite c and d, and so on.
  return {-n[2].dot(n[3]), -n[1].dot(n[3]), -n[1].dot(n[2]),
          -n[0].dot(n[3]), -n[0].dot(n[2]), -n[0].dot(n[1])};
}

}  // namespace

double VolumeMm3(const Corners& x) {
  return (x[1] - x[0]).dot((x[2] - x[0]).cross(x[3] - x[0])) / 6.0;
}

std::array<double, 6> DihedralAnglesRad(const Corners& corners) {
  std::array<double, 6> out = Cosines(corners);
  for (double& value : out) value = std::acos(std::clamp(value, -1.0, 1.0));
  return out;
}

double RadiusEdgeRatio(const Corners& x) {
  const Eigen::Vector3d b = x[1] - x[0];
  const Eigen::Vector3d c = x[2] - x[0];
  const Eigen::Vector3d d = x[3] - x[0];
  const Eigen::Vector3d numerator =
      b.squaredNorm() * c.cross(d) + c.squaredNorm() * d.cross(b) + d.squaredNorm() * b.cross(c);
  const double radius = numerator.norm() / (2.0 * std::abs(b.dot(c.cross(d))));
  double shortest = (x[3] - x[2]).norm();
  for (int i = 0; i < 3; ++i) {
    for (int j = i + 1; j < 4; ++j) shortest = std::min(shortest, (x[i] - x[j]).norm());
  }
  return radius / shortest;
}

double DihedralScore(const Corners& x) {
  const std::array<Eigen::Vector3d, 4> n = FaceNormals(x);
  const double six_volumes = (x[1] - x[0]).dot((x[2] - x[0]).cross(x[3] - x[0]));
  std::array<double, 4> squared{};
  for (int i = 0; i < 4; ++i) squared[i] = n[i].squaredNorm();
  const double area = std::max({squared[0], squared[1], squared[2], squared[3]});
  // Below this the sign of the volume is rounding.
  if (!(six_volumes > 1e-9 * std::sqrt(area * std::sqrt(area)))) return -2.0;
  double largest = -1.0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      largest = std::max(largest, -n[i].dot(n[j]) / std::sqrt(squared[i] * squared[j]));
    }
  }
  return -largest;
}

double ScoreOfDegrees(double degrees) {
  return -std::cos(degrees / kDegrees);
}

double DegreesOfScore(double score) {
  return score < -1.0 ? 0.0 : std::acos(std::clamp(-score, -1.0, 1.0)) * kDegrees;
}

Corners CornersOf(const TetraMesh& mesh, Eigen::Index tetrahedron) {
  Corners out;
  for (int c = 0; c < 4; ++c) out[c] = mesh.nodes_mm.col(mesh.tetrahedra(c, tetrahedron));
  return out;
}

QualityReport MeasureQuality(const TetraMesh& mesh) {
  QualityReport out;
  out.num_nodes = mesh.nodes_mm.cols();
  out.num_tetrahedra = mesh.tetrahedra.cols();
  out.num_fixed_nodes = std::count(mesh.fixed_nodes.begin(), mesh.fixed_nodes.end(), 1);
  out.min_dihedral_deg = 180.0;
  double sum = 0.0;
  for (Eigen::Index t = 0; t < out.num_tetrahedra; ++t) {
    const Corners corners = CornersOf(mesh, t);
    if (!(VolumeMm3(corners) > 0.0)) {
      ++out.num_inverted;
      continue;
    }
    double least = 180.0;
    for (const double angle_rad : DihedralAnglesRad(corners)) {
      const double angle = angle_rad * kDegrees;
      ++out.histogram[std::min<std::size_t>(35, static_cast<std::size_t>(angle / 5.0))];
      least = std::min(least, angle);
      out.max_dihedral_deg = std::max(out.max_dihedral_deg, angle);
    }
    if (least < out.min_dihedral_deg) {
      out.min_dihedral_deg = least;
      out.worst_at_mm = (corners[0] + corners[1] + corners[2] + corners[3]) / 4.0;
    }
    sum += least;
    out.max_radius_edge_ratio = std::max(out.max_radius_edge_ratio, RadiusEdgeRatio(corners));
  }
  const Eigen::Index sound = out.num_tetrahedra - out.num_inverted;
  if (sound > 0) out.mean_min_dihedral_deg = sum / static_cast<double>(sound);
  return out;
}

}  // namespace acus::mesh
