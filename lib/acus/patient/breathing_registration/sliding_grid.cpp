#include "acus/patient/breathing_registration/sliding_grid.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>

#include "acus/base/core/parallel.h"

namespace acus::breathing_registration {
namespace {

using Field = SlidingGrid::Field;

constexpr int kChunk = 8192;
constexpr float kDamping = 1e-4F;  // Of a step, in units of the stiffness.

/// Calls body(n) for all n in fixed chunks; returns the sum of its results, added up in order.
double SumOver(int count, int num_threads, const std::function<double(int, int)>& chunk) {
  const int chunks = (count + kChunk - 1) / kChunk;
  std::vector<double> part(static_cast<std::size_t>(chunks));
  ParallelFor(chunks, num_threads, [&](int c) {
    part[static_cast<std::size_t>(c)] = chunk(c * kChunk, std::min(count, (c + 1) * kChunk));
  });
  double sum = 0.0;
  for (const double value : part) sum += value;
  return sum;
}

}  // namespace

SlidingGrid::SlidingGrid(const volume::Geometry& geometry, const std::vector<Side>& side,
                         const std::vector<Eigen::Vector3f>& normal)
    : geometry_(geometry), node_at_(geometry.num_voxels(), -1) {
  for (std::size_t v = 0; v < side.size(); ++v) {
    if (side[v] == Side::kNone) continue;
    node_at_[v] = static_cast<std::int32_t>(voxel_.size());
    voxel_.push_back(v);
    side_.push_back(side[v]);
    normal_.push_back(normal[v]);
  }
  neighbours_.resize(voxel_.size());
  for (int k = 0; k < geometry.size[2]; ++k) {
    for (int j = 0; j < geometry.size[1]; ++j) {
      for (int i = 0; i < geometry.size[0]; ++i) {
        const std::int32_t n = node_at_[geometry.Index(i, j, k)];
        if (n < 0) continue;
        const auto node = [&](int a, int b, int c) {
          return geometry.Contains(a, b, c) ? node_at_[geometry.Index(a, b, c)] : -1;
        };
        neighbours_[static_cast<std::size_t>(n)] = {node(i - 1, j, k), node(i + 1, j, k),
                                                    node(i, j - 1, k), node(i, j + 1, k),
                                                    node(i, j, k - 1), node(i, j, k + 1)};
      }
    }
  }
}

Eigen::Vector3f SlidingGrid::IndexOf(int node) const {
  const std::size_t v = Voxel(node);
  const auto row = static_cast<std::size_t>(geometry_.size[0]);
  const auto column = static_cast<std::size_t>(geometry_.size[1]);
  return {static_cast<float>(v % row), static_cast<float>(v / row % column),
          static_cast<float>(v / row / column)};
}

Eigen::Matrix3f SlidingGrid::Stiffness(int n) const noexcept {
  Eigen::Matrix3f sum = Eigen::Matrix3f::Zero();
  for (const std::int32_t m : neighbours_[static_cast<std::size_t>(n)]) {
    if (m < 0) continue;
    if (side_[static_cast<std::size_t>(m)] == side_[static_cast<std::size_t>(n)]) {
      sum += Eigen::Matrix3f::Identity();
    } else {
      const Eigen::Vector3f normal = NormalBetween(n, m);
      sum += (kNormalShare - kDrag) * normal * normal.transpose() +
             kDrag * Eigen::Matrix3f::Identity();
    }
  }
  return sum;
}

Eigen::Vector3f SlidingGrid::At(const Field& u, const Eigen::Vector3f& index,
                                Side side) const noexcept {
  const Eigen::Array3i& size = geometry_.size;
  const Eigen::Array3f inside = index.array().max(0.0F).min((size - 1).cast<float>());
  const Eigen::Array3i base = inside.cast<int>().min(size - 2).max(0);
  const Eigen::Array3f t = inside - base.cast<float>();
  Eigen::Vector3f same = Eigen::Vector3f::Zero(), any = Eigen::Vector3f::Zero();
  float same_weight = 0.0F, any_weight = 0.0F;
  for (int corner = 0; corner < 8; ++corner) {
    const int a = corner & 1, b = (corner >> 1) & 1, c = corner >> 2;
    if (!geometry_.Contains(base[0] + a, base[1] + b, base[2] + c)) continue;
    const std::int32_t n = node_at_[geometry_.Index(base[0] + a, base[1] + b, base[2] + c)];
    if (n < 0) continue;
    // A little for corners of weight 0, so that they serve where nothing else does.
    const float weight = (a != 0 ? t[0] : 1.0F - t[0]) * (b != 0 ? t[1] : 1.0F - t[1]) *
                             (c != 0 ? t[2] : 1.0F - t[2]) +
                         1e-6F;
    const Eigen::Vector3f& value = u[static_cast<std::size_t>(n)];
    any += weight * value;
    any_weight += weight;
    if (side_[static_cast<std::size_t>(n)] != side) continue;
    same += weight * value;
    same_weight += weight;
  }
  if (same_weight > 0.0F) return same / same_weight;
  return any_weight > 0.0F ? Eigen::Vector3f(any / any_weight) : any;
}

std::optional<double> SlidingGrid::SmallestDeterminant(const Field& u) const {
  std::optional<double> smallest;
  for (int n = 0; n < num_nodes(); ++n) {
    Eigen::Matrix3d gradient = Eigen::Matrix3d::Identity();
    bool whole = true;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int32_t m =
          neighbours_[static_cast<std::size_t>(n)][static_cast<std::size_t>(2 * axis + 1)];
      whole = m >= 0 && SideOf(m) == SideOf(n);
      if (!whole) break;
      gradient.col(axis) +=
          (u[static_cast<std::size_t>(m)] - u[static_cast<std::size_t>(n)]).cast<double>();
    }
    if (whole) smallest = std::min(smallest.value_or(HUGE_VAL), gradient.determinant());
  }
  return smallest;
}

std::vector<Eigen::Vector3f> SlidingGrid::Everywhere(const Field& u) const {
  std::vector<Eigen::Vector3f> out(geometry_.num_voxels(), Eigen::Vector3f::Zero());
  std::vector<std::uint8_t> known(out.size(), 0);
  std::vector<std::size_t> front;
  for (std::size_t n = 0; n < voxel_.size(); ++n) {
    out[voxel_[n]] = u[n];
    known[voxel_[n]] = 1;
    front.push_back(voxel_[n]);
  }
  const auto row = static_cast<std::size_t>(geometry_.size[0]);
  const std::size_t slice = row * static_cast<std::size_t>(geometry_.size[1]);
  const auto for_neighbours = [&](std::size_t v, const auto& use) {
    const auto i = v % row, j = v / row % static_cast<std::size_t>(geometry_.size[1]),
               k = v / slice;
    if (i > 0) use(v - 1);
    if (i + 1 < row) use(v + 1);
    if (j > 0) use(v - row);
    if (j + 1 < static_cast<std::size_t>(geometry_.size[1])) use(v + row);
    if (k > 0) use(v - slice);
    if (k + 1 < static_cast<std::size_t>(geometry_.size[2])) use(v + slice);
  };
  while (!front.empty()) {
    std::vector<std::size_t> next;
    for (const std::size_t v : front) {
      for_neighbours(v, [&](std::size_t w) {
        if (known[w] != 0) return;
        known[w] = 2;
        next.push_back(w);
      });
    }
    for (const std::size_t v : next) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      int count = 0;
      for_neighbours(v, [&](std::size_t w) {
        if (known[w] != 1) return;
        sum += out[w];
        ++count;
      });
      out[v] = sum / static_cast<float>(std::max(count, 1));
    }
    for (const std::size_t v : next) known[v] = 1;
    front = std::move(next);
  }
  return out;
}

SlidingGrid::Field SolveStep(const SlidingGrid& grid, const DataTerm& data, float stiffness,
                             int iterations, int num_threads) {
  const int count = grid.num_nodes();
  const auto size = static_cast<std::size_t>(count);
  Field x(size, Eigen::Vector3f::Zero()), r = data.force, z(size), p(size), ap(size);
  std::vector<Eigen::Matrix3f> inverse(size);
  const float damping = kDamping * stiffness;
  // z = M^-1 r; returns r . z.
  const auto precondition = [&](int begin, int end) {
    double sum = 0.0;
    for (int i = begin; i < end; ++i) {
      const auto n = static_cast<std::size_t>(i);
      z[n] = inverse[n] * r[n];
      sum += static_cast<double>(r[n].dot(z[n]));
    }
    return sum;
  };
  double rz = SumOver(count, num_threads, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto n = static_cast<std::size_t>(i);
      const Eigen::Vector3f& g = data.gradient[n];
      const Eigen::Matrix3f block =
          g * g.transpose() + stiffness * grid.Stiffness(i) + damping * Eigen::Matrix3f::Identity();
      // In floats, blocks of nodes with few ties would get an inverse that is not positive, and
      // conjugate gradients break down.
      inverse[n] = block.cast<double>().inverse().cast<float>();
    }
    return precondition(begin, end);
  });
  p = z;
  const double start = rz;
  for (int step = 0; step < iterations && rz > 1e-12 * start && rz > 0.0; ++step) {
    const double pap = SumOver(count, num_threads, [&](int begin, int end) {
      double sum = 0.0;
      for (int i = begin; i < end; ++i) {
        const auto n = static_cast<std::size_t>(i);
        const Eigen::Vector3f& g = data.gradient[n];
        ap[n] = g.dot(p[n]) * g + stiffness * grid.Pull(p, i) + damping * p[n];
        sum += static_cast<double>(p[n].dot(ap[n]));
      }
      return sum;
    });
    const auto alpha = static_cast<float>(rz / pap);
    const double next = SumOver(count, num_threads, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const auto n = static_cast<std::size_t>(i);
        x[n] += alpha * p[n];
        r[n] -= alpha * ap[n];
      }
      return precondition(begin, end);
    });
    const auto beta = static_cast<float>(next / rz);
    rz = next;
    SumOver(count, num_threads, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const auto n = static_cast<std::size_t>(i);
        p[n] = z[n] + beta * p[n];
      }
      return 0.0;
    });
  }
  return x;
}

}  // namespace acus::breathing_registration
