#include "acus/imaging/volume_rendering/moving_surface.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"

namespace acus::volume_rendering {
namespace {

constexpr int kChunk = 4096;

/// Calls body(first, end) for pieces of [0, count).
template <class Body>
void InChunks(int count, int num_threads, const Body& body) {
  ParallelFor((count + kChunk - 1) / kChunk, num_threads,
              [&](int chunk) { body(chunk * kChunk, std::min(count, (chunk + 1) * kChunk)); });
}

}  // namespace

void DisplaceVertices(const breathing::MotionMap* motion, const Eigen::Matrix3Xf& rest_mm,
                      Eigen::Matrix3Xf& world_mm, int num_threads) {
  ACUS_ASSERT(rest_mm.cols() == world_mm.cols());
  if (motion == nullptr || !motion->moves()) {
    world_mm = rest_mm;
    return;
  }
  InChunks(static_cast<int>(rest_mm.cols()), num_threads, [&](int first, int end) {
    for (int i = first; i < end; ++i) {
      const Eigen::Vector3d rest = rest_mm.col(i).cast<double>();
      world_mm.col(i) = rest_mm.col(i) + motion->DisplacementMm(rest).cast<float>();
    }
  });
}

MovingSurface::MovingSurface(const mesh::Surface& surface)
    : rest_mm_(surface.nodes_mm.cast<float>()), triangles_(surface.triangles) {
  const auto nodes = static_cast<int>(rest_mm_.cols());
  ACUS_REQUIRE(triangles_.cols() > 0, "surface: it has no triangle");
  ACUS_REQUIRE(triangles_.minCoeff() >= 0 && triangles_.maxCoeff() < nodes,
               "surface: a triangle names node ", triangles_.maxCoeff(), " or below 0; there are ",
               nodes);
  ACUS_REQUIRE(rest_mm_.allFinite(), "surface: a node is at a place that is not finite");
  first_of_node_.assign(static_cast<std::size_t>(nodes) + 1, 0);
  for (const int node : triangles_.reshaped()) ++first_of_node_[static_cast<std::size_t>(node) + 1];
  for (std::size_t n = 1; n < first_of_node_.size(); ++n)
    first_of_node_[n] += first_of_node_[n - 1];
  triangle_of_node_.resize(static_cast<std::size_t>(triangles_.size()));
  std::vector<int> next = first_of_node_;
  for (int t = 0; t < triangles_.cols(); ++t) {
    for (const int node : triangles_.col(t)) {
      triangle_of_node_[static_cast<std::size_t>(next[static_cast<std::size_t>(node)]++)] = t;
    }
  }
  world_mm_.resizeLike(rest_mm_);
  normals_.resizeLike(rest_mm_);
  Update(nullptr, 1);
}

void MovingSurface::Update(const breathing::MotionMap* motion, int num_threads) {
  const bool moves = motion != nullptr && motion->moves();
  if (!moves && at_rest_) return;
  DisplaceVertices(motion, rest_mm_, world_mm_, num_threads);
  UpdateNormals(num_threads);
  at_rest_ = !moves;
}

void MovingSurface::UpdateNormals(int num_threads) {
  InChunks(static_cast<int>(rest_mm_.cols()), num_threads, [&](int first, int end) {
    for (int i = first; i < end; ++i) {
      // Each triangle counts by its area.
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      const auto node = static_cast<std::size_t>(i);
      for (int n = first_of_node_[node]; n < first_of_node_[node + 1]; ++n) {
        const auto corners = triangles_.col(triangle_of_node_[static_cast<std::size_t>(n)]);
        const Eigen::Vector3f a = world_mm_.col(corners[0]);
        const Eigen::Vector3f along = world_mm_.col(corners[1]) - a;
        const Eigen::Vector3f across = world_mm_.col(corners[2]) - a;
        sum += along.cross(across);
      }
      const float length = sum.norm();
      normals_.col(i) = length > 0.0F ? Eigen::Vector3f(sum / length) : Eigen::Vector3f::UnitZ();
    }
  });
}

Eigen::AlignedBox3d MovingSurface::RestBox() const {
  Eigen::AlignedBox3d box;
  for (const auto& node : rest_mm_.colwise()) box.extend(node.cast<double>().eval());
  return box;
}

}  // namespace acus::volume_rendering
