#include "acus/patient/registration/elastic_lattice.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"

namespace acus::registration {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vectors = std::vector<Vector3d>;

constexpr double kPoisson = 0.3;
constexpr double kGround = 1e-7;  ///< Of a node's stiffness: holds what no spring holds.
constexpr double kToleranceMm = 1e-5;
constexpr int kMostIterations = 2000;

/// Corner c of a cube: bits 0, 1, 2 are its place along x, y, z.
Vector3d CornerPlace(int corner) {
  return {static_cast<double>(corner & 1), static_cast<double>((corner >> 1) & 1),
          static_cast<double>((corner >> 2) & 1)};
}

/// Gradient of the trilinear weight of a corner of the unit cube.
Vector3d WeightGradient(int corner, const Vector3d& x) {
  Vector3d value, slope;
  for (int axis = 0; axis < 3; ++axis) {
    const bool high = ((corner >> axis) & 1) != 0;
    value[axis] = high ? x[axis] : 1.0 - x[axis];
    slope[axis] = high ? 1.0 : -1.0;
  }
  return {slope[0] * value[1] * value[2], value[0] * slope[1] * value[2],
          value[0] * value[1] * slope[2]};
}

/// Stiffness of a cube with edge 1 and modulus 1, by 2 x 2 x 2 Gauss points; scales with the edge.
Eigen::Matrix<double, 24, 24> UnitElement() {
  Eigen::Matrix<double, 6, 6> d = Eigen::Matrix<double, 6, 6>::Zero();
  const double factor = 1.0 / ((1.0 + kPoisson) * (1.0 - 2.0 * kPoisson));
  d.topLeftCorner<3, 3>().setConstant(factor * kPoisson);
  d.diagonal().head<3>().setConstant(factor * (1.0 - kPoisson));
  d.diagonal().tail<3>().setConstant(factor * (0.5 - kPoisson));
  Eigen::Matrix<double, 24, 24> element = Eigen::Matrix<double, 24, 24>::Zero();
  for (int gauss = 0; gauss < 8; ++gauss) {
    const Vector3d x =
        Vector3d::Constant(0.5) + (CornerPlace(gauss) - Vector3d::Constant(0.5)) / std::sqrt(3.0);
    Eigen::Matrix<double, 6, 24> b = Eigen::Matrix<double, 6, 24>::Zero();
    for (int c = 0; c < 8; ++c) {
      const Vector3d g = WeightGradient(c, x);
      b.block<6, 3>(0, 3 * c) << g.x(), 0, 0, 0, g.y(), 0, 0, 0, g.z(), g.y(), g.x(), 0, 0, g.z(),
          g.y(), g.z(), 0, g.x();
    }
    element += 0.125 * b.transpose() * d * b;
  }
  return element;
}

/// The dot product in an order that does not depend on threads.
double Dot(const Vectors& a, const Vectors& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

double Largest(const Vectors& a) {
  double largest = 0.0;
  for (const Vector3d& v : a) largest = std::max(largest, v.cwiseAbs().maxCoeff());
  return largest;
}

}  // namespace

LatticeField::LatticeField(const Eigen::AlignedBox3d& box, double spacing_mm)
    : origin_mm_(box.min()), spacing_mm_(spacing_mm) {
  ACUS_ASSERT(!box.isEmpty() && spacing_mm > 0.0);
  size_ = (box.diagonal().array() / spacing_mm).ceil().cast<int>() + 1;
  size_ = size_.max(2);
  nodes_mm_.assign(static_cast<std::size_t>(size_[0]) * size_[1] * size_[2], Vector3d::Zero());
}

LatticeField::Cell LatticeField::CellAt(const Vector3d& rest_mm) const noexcept {
  Cell cell;
  Eigen::Array3i low;
  Vector3d share;
  for (int axis = 0; axis < 3; ++axis) {
    const double place = std::clamp((rest_mm[axis] - origin_mm_[axis]) / spacing_mm_, 0.0,
                                    static_cast<double>(size_[axis] - 1));
    low[axis] = std::min(static_cast<int>(place), size_[axis] - 2);
    share[axis] = place - low[axis];
  }
  for (int c = 0; c < 8; ++c) {
    cell.node[c] = Index(low[0] + (c & 1), low[1] + ((c >> 1) & 1), low[2] + ((c >> 2) & 1));
    double weight = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      weight *= ((c >> axis) & 1) != 0 ? share[axis] : 1.0 - share[axis];
    }
    cell.weight[c] = weight;
  }
  return cell;
}

Vector3d LatticeField::At(const Vector3d& rest_mm) const noexcept {
  const Cell cell = CellAt(rest_mm);
  Vector3d u_mm = Vector3d::Zero();
  for (int c = 0; c < 8; ++c) u_mm += cell.weight[c] * nodes_mm_[cell.node[c]];
  return u_mm;
}

Matrix3d LatticeField::GradientAt(const Vector3d& rest_mm) const noexcept {
  const Cell cell = CellAt(rest_mm);
  Vector3d share = Vector3d::Zero();
  for (int c = 0; c < 8; ++c) share += cell.weight[c] * CornerPlace(c);
  Matrix3d gradient = Matrix3d::Identity();
  for (int c = 0; c < 8; ++c) {
    gradient += nodes_mm_[cell.node[c]] * WeightGradient(c, share).transpose() / spacing_mm_;
  }
  return gradient;
}

ElasticLattice::ElasticLattice(const LatticeField& lattice,
                               const std::function<double(const Vector3d&)>& modulus,
                               int num_threads)
    : lattice_(lattice), element_(lattice.spacing_mm() * UnitElement()) {
  const Eigen::Array3i cells = lattice.size() - 1;
  modulus_.resize(static_cast<std::size_t>(cells[0]) * cells[1] * cells[2]);
  ParallelFor(cells[2], num_threads, [&](int k) {
    for (int j = 0; j < cells[1]; ++j) {
      for (int i = 0; i < cells[0]; ++i) {
        double sum = 0.0;
        for (int c = 0; c < 8; ++c) {
          const Vector3d inside = Vector3d::Constant(0.25) + 0.5 * CornerPlace(c);
          sum += modulus(lattice.PlaceMm(i, j, k) + lattice.spacing_mm() * inside);
        }
        modulus_[(static_cast<std::size_t>(k) * cells[1] + j) * cells[0] + i] = sum / 8.0;
      }
    }
  });
}

void ElasticLattice::Multiply(const Vectors& u, Vectors& force, int num_threads) const {
  const Eigen::Array3i& size = lattice_.size();
  ParallelFor(size[2], num_threads, [&](int k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        Vector3d sum = Vector3d::Zero();
        for (int c = 0; c < 8; ++c) {  // The node is corner c of the cell beside it.
          const int x = i - (c & 1), y = j - ((c >> 1) & 1), z = k - ((c >> 2) & 1);
          if (x < 0 || y < 0 || z < 0 || x >= size[0] - 1 || y >= size[1] - 1 || z >= size[2] - 1) {
            continue;
          }
          Vector3d part = Vector3d::Zero();
          for (int other = 0; other < 8; ++other) {
            const std::size_t node =
                lattice_.Index(x + (other & 1), y + ((other >> 1) & 1), z + ((other >> 2) & 1));
            part += element_.block<3, 3>(3 * c, 3 * other) * u[node];
          }
          sum += modulus_[(static_cast<std::size_t>(z) * (size[1] - 1) + y) * (size[0] - 1) + x] *
                 part;
        }
        force[lattice_.Index(i, j, k)] = sum;
      }
    }
  });
}

std::vector<Matrix3d> ElasticLattice::Diagonal() const {
  const Eigen::Array3i& size = lattice_.size();
  std::vector<Matrix3d> diagonal(lattice_.nodes_mm().size(), Matrix3d::Zero());
  std::size_t cell = 0;
  for (int k = 0; k < size[2] - 1; ++k) {
    for (int j = 0; j < size[1] - 1; ++j) {
      for (int i = 0; i < size[0] - 1; ++i, ++cell) {
        for (int c = 0; c < 8; ++c) {
          diagonal[lattice_.Index(i + (c & 1), j + ((c >> 1) & 1), k + ((c >> 2) & 1))] +=
              modulus_[cell] * element_.block<3, 3>(3 * c, 3 * c);
        }
      }
    }
  }
  return diagonal;
}

int ElasticLattice::Solve(std::span<const Spring> springs, LatticeField& field,
                          int num_threads) const {
  ACUS_ASSERT((field.size() == lattice_.size()).all());
  Vectors& u = field.nodes_mm();
  const std::size_t n = u.size();
  std::vector<LatticeField::Cell> cells;
  for (const Spring& spring : springs) cells.push_back(field.CellAt(spring.rest_mm));
  std::vector<Matrix3d> diagonal = Diagonal();
  std::vector<double> ground(n);
  for (std::size_t i = 0; i < n; ++i) {
    ground[i] = kGround * diagonal[i].trace();
    diagonal[i] += ground[i] * Matrix3d::Identity();
  }
  Vectors right(n, Vector3d::Zero());
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const Vector3d& d = springs[s].direction;
    for (int c = 0; c < 8; ++c) {
      const double weight = springs[s].stiffness * cells[s].weight[c];
      right[cells[s].node[c]] += weight * springs[s].pull_mm * d;
      diagonal[cells[s].node[c]] += weight * cells[s].weight[c] * d * d.transpose();
    }
  }
  for (Matrix3d& block : diagonal) block = block.inverse().eval();
  const auto multiply = [&](const Vectors& x, Vectors& y) {
    Multiply(x, y, num_threads);
    for (std::size_t i = 0; i < n; ++i) y[i] += ground[i] * x[i];
    for (std::size_t s = 0; s < springs.size(); ++s) {
      double along = 0.0;
      for (int c = 0; c < 8; ++c) {
        along += cells[s].weight[c] * springs[s].direction.dot(x[cells[s].node[c]]);
      }
      for (int c = 0; c < 8; ++c) {
        y[cells[s].node[c]] +=
            springs[s].stiffness * along * cells[s].weight[c] * springs[s].direction;
      }
    }
  };
  // Preconditioned conjugate gradients.
  Vectors residual(n), search(n), product(n), scaled(n);
  multiply(u, product);
  for (std::size_t i = 0; i < n; ++i) residual[i] = right[i] - product[i];
  for (std::size_t i = 0; i < n; ++i) scaled[i] = diagonal[i] * residual[i];
  search = scaled;
  double rho = Dot(residual, scaled);
  int iteration = 0;
  for (; iteration < kMostIterations && Largest(scaled) > kToleranceMm; ++iteration) {
    multiply(search, product);
    const double alpha = rho / Dot(search, product);
    for (std::size_t i = 0; i < n; ++i) {
      u[i] += alpha * search[i];
      residual[i] -= alpha * product[i];
      scaled[i] = diagonal[i] * residual[i];
    }
    const double next = Dot(residual, scaled);
    for (std::size_t i = 0; i < n; ++i) search[i] = scaled[i] + next / rho * search[i];
    rho = next;
  }
  return iteration;
}

}  // namespace acus::registration
