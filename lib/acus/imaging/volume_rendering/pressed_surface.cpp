#include "acus/imaging/volume_rendering/pressed_surface.h"

#include <algorithm>

#include "acus/base/core/parallel.h"

namespace acus::volume_rendering {
namespace {

constexpr int kPieceOfNodes = 2048;
constexpr std::uint8_t kMovedNode = 1;
constexpr std::uint8_t kTurnedNode = 2;

}  // namespace

void PressedSurface::Update(const PressedTissue& pressed, const Eigen::Matrix3Xf& nodes_mm,
                            const Eigen::Matrix3Xf& normals, const Eigen::Matrix3Xi& triangles,
                            int num_threads) {
  nodes_mm_ = nodes_mm;
  normals_ = normals;
  const auto count = static_cast<int>(nodes_mm.cols());
  touched_.assign(static_cast<std::size_t>(count), 0);
  num_pressed_ = 0;
  if (pressed.empty()) return;
  // Tissue that is now in the box may come from outside of it by no more than it was moved.
  Eigen::AlignedBox3f reach = pressed.box_in_ct_mm();
  reach.extend((reach.min().array() - pressed.LargestMm()).matrix().eval());
  reach.extend((reach.max().array() + pressed.LargestMm()).matrix().eval());
  ParallelFor((count + kPieceOfNodes - 1) / kPieceOfNodes, num_threads, [&](int piece) {
    const int end = std::min(count, (piece + 1) * kPieceOfNodes);
    for (int i = piece * kPieceOfNodes; i < end; ++i) {
      if (!reach.contains(Eigen::Vector3f(nodes_mm.col(i)))) continue;
      const Eigen::Vector3d from = nodes_mm.col(i).cast<double>();
      const Eigen::Vector3d to = pressed.WorldMm(from).rest_mm;
      if (to == from) continue;
      nodes_mm_.col(i) = to.cast<float>();
      touched_[static_cast<std::size_t>(i)] = kMovedNode;
    }
  });
  num_pressed_ = static_cast<int>(std::ranges::count(touched_, kMovedNode));
  if (num_pressed_ > 0) RenewNormals(triangles);
}

/// Normals of the nodes whose triangles have changed.
void PressedSurface::RenewNormals(const Eigen::Matrix3Xi& triangles) {
  const auto flag = [&](int node) -> std::uint8_t& {
    return touched_[static_cast<std::size_t>(node)];
  };
  const auto any = [&](Eigen::Index t, std::uint8_t bits) {
    return ((flag(triangles(0, t)) | flag(triangles(1, t)) | flag(triangles(2, t))) & bits) != 0;
  };
  for (Eigen::Index t = 0; t < triangles.cols(); ++t) {
    if (!any(t, kMovedNode)) continue;
    for (int corner = 0; corner < 3; ++corner) {
      const int node = triangles(corner, t);
      if ((flag(node) & kTurnedNode) != 0) continue;
      flag(node) |= kTurnedNode;
      normals_.col(node).setZero();
    }
  }
  for (Eigen::Index t = 0; t < triangles.cols(); ++t) {
    if (!any(t, kTurnedNode)) continue;
    const Eigen::Vector3f a = nodes_mm_.col(triangles(0, t));
    const Eigen::Vector3f along = nodes_mm_.col(triangles(1, t)) - a;
    const Eigen::Vector3f across = nodes_mm_.col(triangles(2, t)) - a;
    const Eigen::Vector3f by_area = along.cross(across);
    for (int corner = 0; corner < 3; ++corner) {
      const int node = triangles(corner, t);
      if ((flag(node) & kTurnedNode) != 0) normals_.col(node) += by_area;
    }
  }
  for (Eigen::Index i = 0; i < normals_.cols(); ++i) {
    if ((flag(static_cast<int>(i)) & kTurnedNode) == 0) continue;
    const float length = normals_.col(i).norm();
    if (length > 0.0F) {
      normals_.col(i) /= length;
    } else {
      normals_.col(i) = Eigen::Vector3f::UnitZ();
    }
  }
}

}  // namespace acus::volume_rendering
