#include "acus/data/mesh/nearest_triangle.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "acus/base/core/error.h"

namespace acus::mesh {
namespace {

using Eigen::Vector3d;

constexpr int kLeafSize = 6;
constexpr int kDeepest = 64;

}  // namespace

Vector3d NearestWeights(const Vector3d& x, const Vector3d& a, const Vector3d& b,
                        const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a;
  const Vector3d ax = x - a, bx = x - b, cx = x - c;
  const double d1 = ab.dot(ax), d2 = ac.dot(ax);
  if (d1 <= 0.0 && d2 <= 0.0) return {1, 0, 0};
  const double d3 = ab.dot(bx), d4 = ac.dot(bx);
  if (d3 >= 0.0 && d4 <= d3) return {0, 1, 0};
  const double d5 = ab.dot(cx), d6 = ac.dot(cx);
  if (d6 >= 0.0 && d5 <= d6) return {0, 0, 1};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 > 0.0 && d3 <= 0.0) {
    const double v = d1 / (d1 - d3);
    return {1 - v, v, 0};
  }
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
    const double w = d2 / (d2 - d6);
    return {1 - w, 0, w};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

NearestTriangle::NearestTriangle(const Surface& surface) {
  const Eigen::Index count = surface.triangles.cols();
  ACUS_REQUIRE(count > 0, "the surface has no triangle");
  ACUS_REQUIRE(
      surface.triangles.minCoeff() >= 0 && surface.triangles.maxCoeff() < surface.nodes_mm.cols(),
      "the surface names a node that does not exist");
  corners_.resize(3, 3 * count);
  normals_.resize(3, count);
  Eigen::Matrix3Xd centres(3, count);
  for (Eigen::Index t = 0; t < count; ++t) {
    for (int k = 0; k < 3; ++k) {
      corners_.col(3 * t + k) = surface.nodes_mm.col(surface.triangles(k, t));
    }
    const auto corner = corners_.middleCols<3>(3 * t);
    centres.col(t) = corner.rowwise().mean();
    const Vector3d normal =
        Vector3d(corner.col(1) - corner.col(0)).cross(Vector3d(corner.col(2) - corner.col(0)));
    normals_.col(t) = normal.isZero(0.0) ? normal : normal.stableNormalized();
  }
  order_.resize(static_cast<std::size_t>(count));
  std::iota(order_.begin(), order_.end(), 0);
  Build(0, static_cast<int>(count), centres);
}

int NearestTriangle::Build(int first, int count, const Eigen::Matrix3Xd& centres) {
  const auto index = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  Eigen::AlignedBox3d box, spread;
  for (int i = first; i < first + count; ++i) {
    const int t = order_[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) box.extend(Vector3d(corners_.col(3 * t + k)));
    spread.extend(Vector3d(centres.col(t)));
  }
  nodes_[static_cast<std::size_t>(index)].box = box;
  if (count <= kLeafSize) {
    nodes_[static_cast<std::size_t>(index)].first = first;
    nodes_[static_cast<std::size_t>(index)].count = count;
    return index;
  }
  int axis = 0;
  spread.diagonal().maxCoeff(&axis);
  const auto begin = order_.begin() + first;
  const auto middle = begin + count / 2;
  std::nth_element(begin, middle, begin + count, [&](int a, int b) {
    return centres(axis, a) != centres(axis, b) ? centres(axis, a) < centres(axis, b) : a < b;
  });
  const int left = Build(first, count / 2, centres);
  const int right = Build(first + count / 2, count - count / 2, centres);
  nodes_[static_cast<std::size_t>(index)].first = left;
  nodes_[static_cast<std::size_t>(index)].right = right;
  return index;
}

NearestPoint NearestTriangle::Find(const Vector3d& x_mm) const {
  NearestPoint best;
  best.squared_mm2 = std::numeric_limits<double>::infinity();
  std::array<int, kDeepest> stack;
  int depth = 0;
  stack[0] = 0;
  while (depth >= 0) {
    const Node& node = nodes_[static_cast<std::size_t>(stack[static_cast<std::size_t>(depth--)])];
    if (node.box.squaredExteriorDistance(x_mm) > best.squared_mm2) continue;
    for (int i = node.first; i < node.first + node.count; ++i) {
      const int t = order_[static_cast<std::size_t>(i)];
      const auto corner = corners_.middleCols<3>(3 * t);
      const Vector3d weights = NearestWeights(x_mm, corner.col(0), corner.col(1), corner.col(2));
      const Vector3d point_mm = corner * weights;
      const double squared = (x_mm - point_mm).squaredNorm();
      if (squared > best.squared_mm2 || (squared == best.squared_mm2 && t > best.triangle))
        continue;
      best = {.triangle = t, .point_mm = point_mm, .weights = weights, .squared_mm2 = squared};
    }
    if (node.count > 0) continue;
    // The nearer child last, so that it is looked at first.
    int near = node.first;
    int far = node.right;
    const auto distance = [&](int child) {
      return nodes_[static_cast<std::size_t>(child)].box.squaredExteriorDistance(x_mm);
    };
    if (distance(far) < distance(near)) std::swap(near, far);
    stack[static_cast<std::size_t>(++depth)] = far;
    stack[static_cast<std::size_t>(++depth)] = near;
  }
  return best;
}

}  // namespace acus::mesh
