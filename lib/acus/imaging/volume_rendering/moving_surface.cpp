#include "acus/imaging/volume_rendering/moving_surface.h"

#include <utility>

#include "acus/base/core/error.h"

namespace acus::volume_rendering {
namespace {

/// Normal of each node; each triangle counts by its area.
Eigen::Matrix3Xf NormalsOf(const Eigen::Matrix3Xf& nodes_mm, const Eigen::Matrix3Xi& triangles) {
  Eigen::Matrix3Xf normals = Eigen::Matrix3Xf::Zero(3, nodes_mm.cols());
  for (const auto& corners : triangles.colwise()) {
    const Eigen::Vector3f a = nodes_mm.col(corners[0]);
    const Eigen::Vector3f along = nodes_mm.col(corners[1]) - a;
    const Eigen::Vector3f across = nodes_mm.col(corners[2]) - a;
    const Eigen::Vector3f normal = along.cross(across);
    for (const int node : corners) normals.col(node) += normal;
  }
  for (auto normal : normals.colwise()) {
    const float length = normal.norm();
    normal = length > 0.0F ? Eigen::Vector3f(normal / length) : Eigen::Vector3f::UnitZ();
  }
  return normals;
}

breathing::AttachedPoints NodesOf(const mesh::Surface& surface) {
  const Eigen::Matrix3Xi& triangles = surface.triangles;
  Eigen::Matrix3Xf nodes_mm = surface.nodes_mm.cast<float>();
  ACUS_REQUIRE(triangles.cols() > 0, "surface: it has no triangle");
  ACUS_REQUIRE(triangles.minCoeff() >= 0 && triangles.maxCoeff() < nodes_mm.cols(),
               "surface: a triangle names node ", triangles.maxCoeff(), " or below 0; there are ",
               nodes_mm.cols());
  ACUS_REQUIRE(nodes_mm.allFinite(), "surface: a node is at a place that is not finite");
  Eigen::Matrix3Xf normals = NormalsOf(nodes_mm, triangles);
  return {std::move(nodes_mm), std::move(normals)};
}

}  // namespace

MovingSurface::MovingSurface(const mesh::Surface& surface)
    : nodes_(NodesOf(surface)),
      triangles_(surface.triangles),
      world_mm_(nodes_.rest_mm()),
      normals_(nodes_.rest_normals()) {}

bool MovingSurface::IsAt(const breathing::MotionMap* motion) const {
  if (motion == nullptr) return field_ == 0;
  return field_ == motion->field().identity() && weights_ == motion->weights();
}

void MovingSurface::Update(const breathing::MotionMap* motion, int num_threads) {
  if (motion != nullptr && !motion->moves()) motion = nullptr;
  if (IsAt(motion)) return;
  if (motion == nullptr) {
    world_mm_ = nodes_.rest_mm();
    normals_ = nodes_.rest_normals();
    field_ = 0;
    return;
  }
  nodes_.MoveTo(*motion, num_threads, world_mm_, normals_);
  field_ = motion->field().identity();
  weights_ = motion->weights();
}

Eigen::AlignedBox3d MovingSurface::RestBox() const {
  Eigen::AlignedBox3d box;
  for (const auto& node : nodes_.rest_mm().colwise()) box.extend(node.cast<double>().eval());
  return box;
}

}  // namespace acus::volume_rendering
