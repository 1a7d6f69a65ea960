#include "acus/physics/breathing/attached_points.h"

#include <algorithm>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"
#include "acus/physics/breathing/field_now.h"

namespace acus::breathing {
namespace {

constexpr int kBlocksPerChunk = 256;
constexpr int kPoints = kernels::SurfaceBlock::kPoints;

/// Calls body(first point, number of points, first block) for pieces of `count` points.
template <class Body>
void InChunks(int count, int num_threads, const Body& body) {
  constexpr int kChunk = kBlocksPerChunk * kPoints;
  ParallelFor((count + kChunk - 1) / kChunk, num_threads, [&](int chunk) {
    const int first = chunk * kChunk;
    body(first, std::min(kChunk, count - first), chunk * kBlocksPerChunk);
  });
}

}  // namespace

AttachedPoints::AttachedPoints(Eigen::Matrix3Xf rest_mm, Eigen::Matrix3Xf rest_normals)
    : rest_mm_(std::move(rest_mm)), rest_normals_(std::move(rest_normals)) {
  ACUS_ASSERT(rest_mm_.cols() == rest_normals_.cols());
}

AttachedPoints::Component& AttachedPoints::FindOrLookUp(const MotionField& field, int index,
                                                        int num_threads) {
  for (Component& component : components_) {
    if (component.field == field.identity() && component.index == index) return component;
  }
  Component& component = *std::ranges::min_element(components_, {}, &Component::used);
  component.field = field.identity();
  component.index = index;
  const auto count = static_cast<int>(rest_mm_.cols());
  component.blocks.resize(static_cast<std::size_t>((count + kPoints - 1) / kPoints));
  MotionWeights alone;
  alone.Add(index, 1.0);
  const kernels::FieldNow now = FieldOf({field, alone});
  InChunks(count, num_threads, [&](int first, int points, int block) {
    kernels::LookUpSurface(now, rest_mm_.col(first).data(), rest_normals_.col(first).data(), points,
                           &component.blocks[static_cast<std::size_t>(block)]);
  });
  return component;
}

void AttachedPoints::MoveTo(const MotionMap& motion, int num_threads, Eigen::Matrix3Xf& world_mm,
                            Eigen::Matrix3Xf& normals) {
  ACUS_ASSERT(motion.moves() && world_mm.cols() == rest_mm_.cols() &&
              normals.cols() == rest_mm_.cols());
  ++moment_;
  const MotionWeights& weights = motion.weights();
  kernels::SurfaceNow now;
  now.num_components = weights.count;
  for (int n = 0; n < weights.count; ++n) {
    const auto at = static_cast<std::size_t>(n);
    Component& component = FindOrLookUp(motion.field(), weights.component[at], num_threads);
    component.used = moment_;
    now.blocks[n] = component.blocks.data();
    now.weight[n] = weights.weight[at];
  }
  InChunks(static_cast<int>(rest_mm_.cols()), num_threads, [&](int first, int points, int block) {
    kernels::SurfaceNow here = now;
    for (int n = 0; n < here.num_components; ++n) here.blocks[n] += block;
    kernels::MoveSurface(here, rest_mm_.col(first).data(), rest_normals_.col(first).data(), points,
                         world_mm.col(first).data(), normals.col(first).data());
  });
}

}  // namespace acus::breathing
