#include "acus/imaging/volume_rendering/moving_surface.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"
#include "acus/physics/breathing/moved_points.h"

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
    const auto rest = rest_mm.middleCols(first, end - first);
    auto world = world_mm.middleCols(first, end - first);
    breathing::DisplacementsMm(*motion, rest, world);
    world += rest;
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
  world_mm_.resizeLike(rest_mm_);
  SetRestNormals();
  normals_.resizeLike(rest_mm_);
  Update(nullptr, 1);
}

/// Each triangle counts by its area.
void MovingSurface::SetRestNormals() {
  rest_normals_ = Eigen::Matrix3Xf::Zero(3, rest_mm_.cols());
  for (const auto& corners : triangles_.colwise()) {
    const Eigen::Vector3f a = rest_mm_.col(corners[0]);
    const Eigen::Vector3f along = rest_mm_.col(corners[1]) - a;
    const Eigen::Vector3f across = rest_mm_.col(corners[2]) - a;
    const Eigen::Vector3f normal = along.cross(across);
    for (const int node : corners) rest_normals_.col(node) += normal;
  }
  for (auto normal : rest_normals_.colwise()) {
    const float length = normal.norm();
    normal = length > 0.0F ? Eigen::Vector3f(normal / length) : Eigen::Vector3f::UnitZ();
  }
}

void MovingSurface::Update(const breathing::MotionMap* motion, int num_threads) {
  const bool moves = motion != nullptr && motion->moves();
  if (!moves && at_rest_) return;
  at_rest_ = !moves;
  if (!moves) {
    world_mm_ = rest_mm_;
    normals_ = rest_normals_;
    return;
  }
  InChunks(static_cast<int>(rest_mm_.cols()), num_threads, [&](int first, int end) {
    const int count = end - first;
    breathing::MoveWithNormals(
        *motion, rest_mm_.middleCols(first, count), rest_normals_.middleCols(first, count),
        world_mm_.middleCols(first, count), normals_.middleCols(first, count));
  });
}

Eigen::AlignedBox3d MovingSurface::RestBox() const {
  Eigen::AlignedBox3d box;
  for (const auto& node : rest_mm_.colwise()) box.extend(node.cast<double>().eval());
  return box;
}

}  // namespace acus::volume_rendering
