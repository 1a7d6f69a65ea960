#include "acus/physics/mechanics/elements/plane_strain.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "acus/base/core/error.h"
#include "acus/physics/mechanics/sparse/blas.h"

namespace acus::mechanics {
namespace {

constexpr double kLeastStiffness = 1e-12;  // Relative; below it a part is not held.

using StrainRow = Eigen::Matrix<double, 1, 6>;

/// Strain of a constant-strain triangle: strain = rows times the displacements (x0, y0, x1, y1, x2,
/// y2).
struct Strain {
  double area_mm2 = 0.0;
  StrainRow xx, yy, xy;  ///< xy: engineering shear.
  StrainRow Dilatation() const { return xx + yy; }
};

Strain StrainOf(const PlaneGrid& grid, const std::array<int, 3>& nodes) {
  std::array<Eigen::Vector2d, 3> p;
  for (int i = 0; i < 3; ++i) p[i] = grid.PositionMm(nodes[i]);
  const Eigen::Vector2d a = p[1] - p[0];
  const Eigen::Vector2d b = p[2] - p[0];
  const double twice_area = a.x() * b.y() - a.y() * b.x();
  ACUS_ASSERT(twice_area > 0.0);
  Strain strain;
  strain.area_mm2 = 0.5 * twice_area;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d& next = p[(i + 1) % 3];
    const Eigen::Vector2d& last = p[(i + 2) % 3];
    const double dx = (next.y() - last.y()) / twice_area;
    const double dy = (last.x() - next.x()) / twice_area;
    strain.xx.segment<2>(2 * i) << dx, 0.0;
    strain.yy.segment<2>(2 * i) << 0.0, dy;
    strain.xy.segment<2>(2 * i) << dy, dx;
  }
  return strain;
}

void CheckTissue(const std::vector<ElasticTissue>& tissue) {
  for (std::size_t t = 0; t < tissue.size(); ++t) {
    const ElasticTissue& row = tissue[t];
    ACUS_REQUIRE(row.youngs_modulus_mpa >= 0.0 && std::isfinite(row.youngs_modulus_mpa) &&
                     (row.youngs_modulus_mpa == kEmptyMpa ||
                      (row.poissons_ratio > -1.0 && row.poissons_ratio < 0.5)),
                 "triangle ", t, " has Young's modulus ", row.youngs_modulus_mpa,
                 " MPa and Poisson's ratio ", row.poissons_ratio,
                 "; allowed: at least 0 MPa, and a ratio in (-1, 0.5)");
  }
}

bool SameTissue(const ElasticTissue& a, const ElasticTissue& b) {
  return a.youngs_modulus_mpa == b.youngs_modulus_mpa && a.poissons_ratio == b.poissons_ratio;
}

class Assembler {
 public:
  explicit Assembler(const PlaneGrid& grid) : grid_(grid) {
    entries_.reserve(static_cast<std::size_t>(grid.num_triangles()) * 72);
  }

  /// Adds factor * a^T b over the unknowns of two triangles.
  void Add(int triangle_a, const StrainRow& a, int triangle_b, const StrainRow& b, double factor) {
    const std::array<int, 3> nodes_a = grid_.Triangle(triangle_a);
    const std::array<int, 3> nodes_b = grid_.Triangle(triangle_b);
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        entries_.emplace_back(2 * nodes_a[i / 2] + i % 2, 2 * nodes_b[j / 2] + j % 2,
                              factor * a[i] * b[j]);
      }
    }
  }

  Eigen::SparseMatrix<double> Matrix() const {
    Eigen::SparseMatrix<double> matrix(2 * grid_.num_nodes(), 2 * grid_.num_nodes());
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    return matrix;
  }

 private:
  const PlaneGrid& grid_;
  std::vector<Eigen::Triplet<double>> entries_;
};

}  // namespace

std::array<int, 3> PlaneGrid::Triangle(int triangle) const {
  const int cell = triangle / 2;
  const int column = cell % (columns - 1);
  const int row = cell / (columns - 1);
  const int n00 = Node(column, row);
  const int n10 = n00 + 1;
  const int n01 = n00 + columns;
  const int n11 = n01 + 1;
  const bool lower = triangle % 2 == 0;
  if ((column + row) % 2 == 0) {
    return lower ? std::array<int, 3>{n00, n10, n11} : std::array<int, 3>{n00, n11, n01};
  }
  return lower ? std::array<int, 3>{n00, n10, n01} : std::array<int, 3>{n10, n11, n01};
}

Eigen::Vector2d PlaneGrid::CentroidMm(int triangle) const {
  const std::array<int, 3> nodes = Triangle(triangle);
  return (PositionMm(nodes[0]) + PositionMm(nodes[1]) + PositionMm(nodes[2])) / 3.0;
}

PlaneGrid::Place PlaneGrid::PlaceOf(const Eigen::Vector2d& point_mm) const noexcept {
  Place place;
  const double x = point_mm.x() / spacing_mm;
  const double y = point_mm.y() / spacing_mm;
  if (!(x >= 0.0 && y >= 0.0 && x <= columns - 1 && y <= rows - 1)) return place;
  const int column = std::min(static_cast<int>(x), columns - 2);
  const int row = std::min(static_cast<int>(y), rows - 2);
  const double u = x - column;
  const double v = y - row;
  const int cell = row * (columns - 1) + column;
  const bool rising = (column + row) % 2 == 0;  // Diagonal from (0, 0) to (1, 1).
  const bool lower = rising ? v <= u : u + v <= 1.0;
  place.triangle = 2 * cell + (lower ? 0 : 1);
  place.node = Triangle(place.triangle);
  if (rising) {
    place.weight =
        lower ? std::array<double, 3>{1.0 - u, u - v, v} : std::array<double, 3>{1.0 - v, u, v - u};
  } else {
    place.weight = lower ? std::array<double, 3>{1.0 - u - v, u, v}
                         : std::array<double, 3>{1.0 - v, u + v - 1.0, 1.0 - u};
  }
  return place;
}

int EmptyUnsupported(const PlaneGrid& grid, const std::vector<char>& fixed,
                     std::vector<ElasticTissue>& tissue) {
  std::vector<int> part(tissue.size());
  std::iota(part.begin(), part.end(), 0);
  const auto find = [&](int t) {
    while (part[t] != t) t = part[t] = part[part[t]];
    return t;
  };
  std::map<std::pair<int, int>, int> edges;
  for (int t = 0; t < grid.num_triangles(); ++t) {
    if (tissue[t].youngs_modulus_mpa == kEmptyMpa) continue;
    const std::array<int, 3> nodes = grid.Triangle(t);
    for (int i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(nodes[i], nodes[(i + 1) % 3]);
      const auto [found, is_new] = edges.try_emplace({low, high}, t);
      if (!is_new) part[find(t)] = find(found->second);
    }
  }
  // Distinct fixed nodes of each part; two hold a body in the plane.
  std::vector<int> first(tissue.size(), -1);
  std::vector<char> held(tissue.size(), 0);
  for (int t = 0; t < grid.num_triangles(); ++t) {
    if (tissue[t].youngs_modulus_mpa == kEmptyMpa) continue;
    const int root = find(t);
    for (const int node : grid.Triangle(t)) {
      if (fixed[node] == 0) continue;
      if (first[root] < 0) first[root] = node;
      if (first[root] != node) held[root] = 1;
    }
  }
  int emptied = 0;
  for (int t = 0; t < grid.num_triangles(); ++t) {
    if (tissue[t].youngs_modulus_mpa == kEmptyMpa || held[find(t)] != 0) continue;
    tissue[t].youngs_modulus_mpa = kEmptyMpa;
    ++emptied;
  }
  return emptied;
}

Eigen::SparseMatrix<double> PlaneStiffness(const PlaneGrid& grid,
                                           const std::vector<ElasticTissue>& tissue,
                                           Dilatation dilatation) {
  ACUS_ASSERT(static_cast<int>(tissue.size()) == grid.num_triangles());
  CheckTissue(tissue);
  Assembler assembler(grid);
  for (int cell = 0; cell < grid.num_cells(); ++cell) {
    const int pair[] = {2 * cell, 2 * cell + 1};
    const bool together =
        dilatation == Dilatation::kCell && SameTissue(tissue[pair[0]], tissue[pair[1]]);
    for (const int t : pair) {
      if (tissue[t].youngs_modulus_mpa == kEmptyMpa) continue;
      const Strain strain = StrainOf(grid, grid.Triangle(t));
      // Twice the energy: 2 G (e:e - theta^2 / 3) + K mean_theta^2; e has no out-of-plane part.
      const double shear = tissue[t].ShearModulusMpa() * strain.area_mm2;
      const double bulk = tissue[t].BulkModulusMpa() * strain.area_mm2;
      assembler.Add(t, strain.xx, t, strain.xx, 2.0 * shear);
      assembler.Add(t, strain.yy, t, strain.yy, 2.0 * shear);
      assembler.Add(t, strain.xy, t, strain.xy, shear);
      assembler.Add(t, strain.Dilatation(), t, strain.Dilatation(), -2.0 / 3.0 * shear);
      if (!together) {
        assembler.Add(t, strain.Dilatation(), t, strain.Dilatation(), bulk);
        continue;
      }
      // Both triangles have the same area: K 2 A ((theta_1 + theta_2) / 2)^2.
      for (const int other : pair) {
        const Strain beside = StrainOf(grid, grid.Triangle(other));
        assembler.Add(t, strain.Dilatation(), other, beside.Dilatation(), 0.5 * bulk);
      }
    }
  }
  return assembler.Matrix();
}

PlaneCompliance InvertPlane(const PlaneGrid& grid, const std::vector<ElasticTissue>& tissue,
                            const std::vector<char>& fixed, Dilatation dilatation) {
  ACUS_ASSERT(static_cast<int>(fixed.size()) == grid.num_nodes());
  PlaneCompliance out;
  out.dof_of_node.assign(grid.num_nodes(), -1);
  for (int t = 0; t < grid.num_triangles(); ++t) {
    if (tissue[t].youngs_modulus_mpa == kEmptyMpa) continue;
    for (const int node : grid.Triangle(t)) out.dof_of_node[node] = fixed[node] != 0 ? -1 : 0;
  }
  int num_dofs = 0;
  for (int& dof : out.dof_of_node) {
    if (dof < 0) continue;
    dof = num_dofs;
    num_dofs += 2;
  }
  ACUS_REQUIRE(num_dofs > 0, "the plane of ", grid.columns, " x ", grid.rows,
               " nodes has no free node; allowed: at least one with tissue around it that is not "
               "fixed; try a larger region or another place");
  const Eigen::SparseMatrix<double> stiffness = PlaneStiffness(grid, tissue, dilatation);
  out.matrix.setZero(num_dofs, num_dofs);
  for (int column = 0; column < stiffness.outerSize(); ++column) {
    const int to = out.dof_of_node[column / 2];
    if (to < 0) continue;
    for (Eigen::SparseMatrix<double>::InnerIterator it(stiffness, column); it; ++it) {
      const int from = out.dof_of_node[it.row() / 2];
      if (from >= 0) out.matrix(from + it.row() % 2, to + column % 2) = it.value();
    }
  }
  const Eigen::VectorXd diagonal = out.matrix.diagonal();
  HoldBlasToOneThread();
  int info = 0;
  dpotrf_("L", &num_dofs, out.matrix.data(), &num_dofs, &info);
  for (int i = 0; i < num_dofs && info == 0; ++i) {
    // What remains of the diagonal after elimination: the stiffness with all others free.
    const double left = out.matrix(i, i) * out.matrix(i, i);
    if (!(left > kLeastStiffness * diagonal[i])) info = i + 1;
  }
  if (info == 0) dpotri_("L", &num_dofs, out.matrix.data(), &num_dofs, &info);
  ACUS_REQUIRE(info == 0, "the stiffness of the plane is not positive definite (unknown ", info,
               " of ", num_dofs,
               "): a part of the tissue can move without resistance; fix more nodes or empty the "
               "part (EmptyUnsupported)");
  out.matrix.triangularView<Eigen::StrictlyUpper>() = out.matrix.transpose();
  return out;
}

}  // namespace acus::mechanics
