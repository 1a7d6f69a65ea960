#include "acus/physics/mechanics/elements/membrane.h"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <map>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/physics/mechanics/elements/face_neighbours.h"

namespace acus::mechanics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Triplets = std::vector<Eigen::Triplet<double>>;

/// Outward corner order of the faces of a tetrahedron of positive volume.
constexpr int kShellFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
/// Six corners on one conic do not determine a curvature: what they say less about is taken as 0.
constexpr double kLeastDetermined = 0.05;
/// Faces that meet at more than 60 degrees are a fold: each has a rim there.
constexpr double kFoldCosine = 0.5;

/// The plane of a face: where its corners and the opposite ones are in it, and how each moves w.
struct FlatFace {
  Vector3d normal, first, second;
  std::array<Vector2d, 6> place;
  double area_mm2 = 0.0;
  /// Gradient of the linear function that is 1 at corner n and 0 at the others.
  std::array<Vector2d, 3> gradient;
};

FlatFace Flatten(const mesh::TetraMesh& mesh, const MembraneFace& face) {
  FlatFace out;
  const Vector3d a = mesh.nodes_mm.col(face.corner[0]);
  const Vector3d b = mesh.nodes_mm.col(face.corner[1]);
  const Vector3d c = mesh.nodes_mm.col(face.corner[2]);
  const Vector3d cross = (b - a).cross(c - a);
  out.area_mm2 = 0.5 * cross.norm();
  out.normal = cross.normalized();
  out.first = (b - a).normalized();
  out.second = out.normal.cross(out.first);
  for (std::size_t n = 0; n < 6; ++n) {
    const int node = n < 3 ? face.corner[n] : face.opposite[n - 3];
    if (node < 0) continue;
    const Vector3d x = mesh.nodes_mm.col(node) - a;
    out.place[n] = {x.dot(out.first), x.dot(out.second)};
  }
  for (std::size_t n = 0; n < 3; ++n) {
    const Vector2d edge = out.place[(n + 2) % 3] - out.place[(n + 1) % 3];
    out.gradient[n] = Vector2d(-edge.y(), edge.x()) / (2.0 * out.area_mm2);
  }
  return out;
}

/// w_xx, w_yy, w_xy of the face by w of the six corners. A linear w gives 0 whatever the patch.
Eigen::Matrix<double, 3, 6> CurvatureOf(const FlatFace& flat, const MembraneFace& face) {
  const auto quadratic = [](const Vector2d& x) {
    return Vector3d(0.5 * x.x() * x.x(), 0.5 * x.y() * x.y(), x.x() * x.y());
  };
  Matrix3d bulge = Matrix3d::Zero();  // Of a curvature, at each opposite corner over the plane.
  Eigen::Matrix<double, 3, 6> off = Eigen::Matrix<double, 3, 6>::Zero();
  for (std::size_t o = 0; o < 3; ++o) {
    if (face.opposite[o] < 0) continue;
    const Eigen::Index row = static_cast<Eigen::Index>(o);
    const Vector2d& x = flat.place[o + 3];
    Vector3d above = quadratic(x);
    off(row, row + 3) = 1.0;
    for (std::size_t n = 0; n < 3; ++n) {
      const std::size_t next = (n + 1) % 3;
      const double share = flat.gradient[n].dot(x - flat.place[next]);
      off(row, static_cast<Eigen::Index>(n)) = -share;
      above -= share * quadratic(flat.place[n]);
    }
    bulge.row(row) = above.transpose();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(bulge, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d inverse = Vector3d::Zero();
  for (int n = 0; n < 3; ++n) {
    const double value = svd.singularValues()[n];
    if (value > kLeastDetermined * flat.area_mm2) inverse[n] = 1.0 / value;
  }
  return svd.matrixV() * inverse.asDiagonal() * svd.matrixU().transpose() * off;
}

/// Adds what is in the lower triangle.
void AddBlock(const Matrix3d& block, int row, int column, Triplets& out) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (3 * row + i >= 3 * column + j) {
        out.emplace_back(3 * row + i, 3 * column + j, block(i, j));
      }
    }
  }
}

void AddStretching(const Membrane& membrane, const FlatFace& flat, const MembraneFace& face,
                   Triplets& out) {
  const double nu = membrane.poissons_ratio;
  const double scale = membrane.StretchingStiffnessNPerMm() * flat.area_mm2;
  for (std::size_t n = 0; n < 3; ++n) {
    for (std::size_t m = 0; m < 3; ++m) {
      const Vector2d& g = flat.gradient[n];
      const Vector2d& h = flat.gradient[m];
      Eigen::Matrix2d k;
      k(0, 0) = g.x() * h.x() + 0.5 * (1.0 - nu) * g.y() * h.y();
      k(0, 1) = nu * g.x() * h.y() + 0.5 * (1.0 - nu) * g.y() * h.x();
      k(1, 0) = nu * g.y() * h.x() + 0.5 * (1.0 - nu) * g.x() * h.y();
      k(1, 1) = g.y() * h.y() + 0.5 * (1.0 - nu) * g.x() * h.x();
      Eigen::Matrix<double, 3, 2> axes;
      axes << flat.first, flat.second;
      Matrix3d block = scale * axes * k * axes.transpose();
      block += membrane.tension_n_per_mm * flat.area_mm2 * g.dot(h) * flat.normal *
               flat.normal.transpose();
      AddBlock(block, face.corner[n], face.corner[m], out);
    }
  }
}

void AddBending(const Membrane& membrane, const FlatFace& flat, const MembraneFace& face,
                Triplets& out) {
  const double nu = membrane.poissons_ratio;
  Matrix3d moment;
  moment << 1.0, nu, 0.0, nu, 1.0, 0.0, 0.0, 0.0, 2.0 * (1.0 - nu);
  const Eigen::Matrix<double, 3, 6> curvature = CurvatureOf(flat, face);
  const Eigen::Matrix<double, 6, 6> k =
      membrane.BendingStiffnessNmm() * flat.area_mm2 * curvature.transpose() * moment * curvature;
  const Matrix3d along = flat.normal * flat.normal.transpose();
  const auto node = [&](Eigen::Index n) {
    return n < 3 ? face.corner[static_cast<std::size_t>(n)]
                 : face.opposite[static_cast<std::size_t>(n - 3)];
  };
  for (Eigen::Index n = 0; n < 6; ++n) {
    for (Eigen::Index m = 0; m < 6; ++m) {
      if (node(n) >= 0 && node(m) >= 0) AddBlock(k(n, m) * along, node(n), node(m), out);
    }
  }
}

}  // namespace

double Membrane::BendingStiffnessNmm() const {
  return StretchingStiffnessNPerMm() * thickness_mm * thickness_mm / 12.0;
}

double Membrane::StretchingStiffnessNPerMm() const {
  return youngs_modulus_mpa * thickness_mm / (1.0 - poissons_ratio * poissons_ratio);
}

std::vector<MembraneFace> FacesOf(const Membrane& membrane, const mesh::TetraMesh& mesh,
                                  std::span<const std::uint8_t> is_left_out) {
  const Eigen::Matrix4Xi neighbours = FaceNeighbours(mesh);
  const auto label = [&](int t) {
    const bool is_there =
        t >= 0 && (is_left_out.empty() || is_left_out[static_cast<std::size_t>(t)] == 0);
    return is_there ? mesh.tissue[static_cast<std::size_t>(t)] : volume::Label{0};
  };
  std::vector<MembraneFace> out;
  for (int t = 0; t < mesh.tetrahedra.cols(); ++t) {
    if (label(t) != membrane.tissue) continue;
    for (int c = 0; c < 4; ++c) {
      const volume::Label beyond = label(neighbours(c, t));
      if (beyond == membrane.tissue || !membrane.against.test(beyond)) continue;
      MembraneFace face;
      for (std::size_t n = 0; n < 3; ++n) face.corner[n] = mesh.tetrahedra(kShellFaces[c][n], t);
      out.push_back(face);
    }
  }
  // Faces side by side: the two of an edge. Where more meet, none is another's continuation.
  struct Side {
    int face, across;
  };
  std::map<std::array<int, 2>, std::vector<Side>> edges;
  for (int f = 0; f < static_cast<int>(out.size()); ++f) {
    const auto& corner = out[static_cast<std::size_t>(f)].corner;
    for (int n = 0; n < 3; ++n) {
      const auto [low, high] = std::minmax(corner[static_cast<std::size_t>((n + 1) % 3)],
                                           corner[static_cast<std::size_t>((n + 2) % 3)]);
      edges[{low, high}].push_back({f, n});
    }
  }
  const auto normal = [&](int f) {
    const auto& corner = out[static_cast<std::size_t>(f)].corner;
    const Vector3d a = mesh.nodes_mm.col(corner[0]);
    const Vector3d b = mesh.nodes_mm.col(corner[1]);
    const Vector3d c = mesh.nodes_mm.col(corner[2]);
    return (b - a).cross(c - a).normalized();
  };
  for (const auto& [edge, sides] : edges) {
    if (sides.size() != 2 || normal(sides[0].face).dot(normal(sides[1].face)) < kFoldCosine)
      continue;
    for (std::size_t s = 0; s < 2; ++s) {
      const Side& other = sides[1 - s];
      out[static_cast<std::size_t>(sides[s].face)]
          .opposite[static_cast<std::size_t>(sides[s].across)] =
          out[static_cast<std::size_t>(other.face)].corner[static_cast<std::size_t>(other.across)];
    }
  }
  return out;
}

Eigen::SparseMatrix<double> MembraneStiffness(const mesh::TetraMesh& mesh,
                                              std::span<const Membrane> membranes,
                                              std::span<const std::uint8_t> is_left_out) {
  Triplets entries;
  for (const Membrane& membrane : membranes) {
    for (const MembraneFace& face : FacesOf(membrane, mesh, is_left_out)) {
      const FlatFace flat = Flatten(mesh, face);
      if (!(flat.area_mm2 > 0.0)) continue;
      AddStretching(membrane, flat, face, entries);
      AddBending(membrane, flat, face, entries);
    }
  }
  const Eigen::Index size = 3 * mesh.nodes_mm.cols();
  Eigen::SparseMatrix<double> out(size, size);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

double MembraneComplianceMmPerN(const Membrane& membrane, double shear_mpa, double poissons_ratio,
                                double radius_mm) {
  const double bending = membrane.BendingStiffnessNmm();
  const double foundation = shear_mpa / (1.0 - poissons_ratio);
  ACUS_ASSERT(foundation > 0.0 && (radius_mm > 0.0 || bending > 0.0));
  const auto integrand = [&](double k) {
    double weight = 1.0;
    const double kr = k * radius_mm;
    if (kr > 1e-3) {
      const double transform = 48.0 * boost::math::cyl_bessel_j(3, kr) / (kr * kr * kr);
      weight = transform * transform;
    }
    return weight / (bending * k * k * k + membrane.tension_n_per_mm * k + foundation);
  };
  // Where the load, bending and the ground end the integral; a rational map covers the rest.
  const double scale = std::min(radius_mm > 0.0 ? 4.0 / radius_mm : 1e9,
                                bending > 0.0 ? std::cbrt(foundation / bending) : 1e9);
  const auto mapped = [&](double s) {
    const double k = scale * s / (1.0 - s);
    return integrand(k) * scale / ((1.0 - s) * (1.0 - s));
  };
  using Rule = boost::math::quadrature::gauss_kronrod<double, 31>;
  return Rule::integrate(mapped, 0.0, 1.0 - 1e-9, 12, 1e-9) / (2.0 * std::numbers::pi);
}

}  // namespace acus::mechanics
