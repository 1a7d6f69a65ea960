#include "acus/patient/breathing_registration/error_bound.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/parallel.h"
#include "acus/patient/breathing_registration/sided_sums.h"

namespace acus::breathing_registration {
namespace {

using Eigen::Array3i;
using Eigen::Vector3f;

constexpr int kScales = 6;
// Constants of the fit to the landmarks of two CTs; lengths in distances of the nodes.
constexpr float kStrainReach = 1.3F, kDisagreement = 0.42F;
constexpr float kWallReach = 2.0F, kWallLayerMm = 8.0F;
constexpr float kSmallestMm = 0.05F;
constexpr float kSeenEnough = 0.25F;  // Share of the nodes of a cube.

/// What is summed of each node.
enum Number { kCount, kSeen, kStrain2, kDisagreement2, kNearWall };

/// Square of the strain's norm at a node, from differences to nodes of its side.
float SquaredStrain(const SlidingGrid& grid, const SlidingGrid::Field& u, int n,
                    const Array3i& at) {
  const volume::Geometry& g = grid.geometry();
  float sum = 0.0F;
  for (int axis = 0; axis < 3; ++axis) {
    Array3i next = at;
    next[axis] += 1;
    if (!g.Contains(next[0], next[1], next[2])) continue;
    const std::int32_t m = grid.NodeAt(g.Index(next[0], next[1], next[2]));
    if (m < 0 || grid.SideOf(m) != grid.SideOf(n)) continue;
    sum += (u[static_cast<std::size_t>(m)] - u[static_cast<std::size_t>(n)]).squaredNorm();
  }
  return sum;
}

SidedSums SumsOf(const SlidingGrid& grid, const Solution& solution) {
  const volume::Geometry& g = grid.geometry();
  const auto row = static_cast<std::size_t>(g.size[0]);
  const auto column = static_cast<std::size_t>(g.size[1]);
  SidedSums sums(g.size, kScales);
  for (int i = 0; i < grid.num_nodes(); ++i) {
    const auto n = static_cast<std::size_t>(i);
    const std::size_t v = grid.Voxel(i);
    const Array3i at(static_cast<int>(v % row), static_cast<int>(v / row % column),
                     static_cast<int>(v / row / column));
    const auto& u = solution.displacement_voxels;
    SidedSums::Numbers numbers;
    numbers[kCount] = 1.0F;
    numbers[kSeen] = solution.is_seen[n] != 0 ? 1.0F : 0.0F;
    numbers[kStrain2] = SquaredStrain(grid, u, i, at);
    numbers[kDisagreement2] = (u[n] - solution.coarser_voxels[n]).squaredNorm();
    numbers[kNearWall] = std::exp(-solution.wall_mm[n] / kWallLayerMm);
    sums.Add(at, grid.SideOf(i), numbers);
  }
  sums.Finish();
  return sums;
}

/// Root mean square of the strain over the whole phase.
float StrainOfPhase(const SidedSums& sums) {
  SidedSums::Numbers all = SidedSums::Numbers::Zero();
  for (int k = 0; k < sums.size()[2]; ++k) {
    for (int j = 0; j < sums.size()[1]; ++j) {
      for (int i = 0; i < sums.size()[0]; ++i) {
        const Vector3f at =
            2.0F * Array3i(i, j, k).cast<float>().matrix() + Vector3f::Constant(0.5F);
        all += sums.At(at, Side::kWall, 0) + sums.At(at, Side::kCavity, 0);
      }
    }
  }
  return std::sqrt(all[kStrain2] / std::max(all[kCount], 1.0F));
}

float Mean(const SidedSums::Numbers& numbers, Number which) {
  return numbers[which] / std::max(numbers[kCount], 1e-6F);
}

/// Nodes to the nearest match that images show; 0 where they do.
float UnseenReach(const SidedSums& sums, const Vector3f& at, Side side) {
  if (Mean(sums.At(at, side, 0), kSeen) >= kSeenEnough) return 0.0F;
  for (int scale = 1; scale < kScales; ++scale) {
    if (Mean(sums.At(at, side, scale), kSeen) >= kSeenEnough) {
      return static_cast<float>(2 << scale);
    }
  }
  return static_cast<float>(2 << kScales);
}

/// @param h_mm  Distance of the nodes.
float BoundMm(const SidedSums& sums, float strain_of_phase, float h_mm, const Vector3f& at,
              Side side) {
  const SidedSums::Numbers small = sums.At(at, side, 1), large = sums.At(at, side, 3);
  const float strain = std::sqrt(0.5F * (Mean(small, kStrain2) + Mean(large, kStrain2)));
  const float reach = std::hypot(kStrainReach, UnseenReach(sums, at, side));
  return h_mm * std::hypot(reach * strain, kDisagreement * std::sqrt(Mean(small, kDisagreement2)),
                           kWallReach * strain_of_phase * Mean(sums.At(at, side, 0), kNearWall));
}

}  // namespace

ErrorBound::ErrorBound(const SlidingGrid& grid, const Solution& solution, int num_threads) {
  const SidedSums sums = SumsOf(grid, solution);
  const float strain_of_phase = StrainOfPhase(sums);
  const auto h = static_cast<float>(grid.geometry().spacing_mm[0]);
  size_ = sums.size();
  const auto unseen = std::ranges::count(solution.is_seen, std::uint8_t{0});
  unseen_share_ = static_cast<double>(unseen) / grid.num_nodes();
  for (const Side side : {Side::kWall, Side::kCavity}) {
    auto& cubes = cubes_[SideIndex(side)];
    cubes.assign(CubeAt(size_, size_ - 1) + 1, {});
    ParallelFor(size_[2], num_threads, [&](int k) {
      for (int j = 0; j < size_[1]; ++j) {
        for (int i = 0; i < size_[0]; ++i) {
          const Vector3f at =
              2.0F * Array3i(i, j, k).cast<float>().matrix() + Vector3f::Constant(0.5F);
          const SidedSums::Numbers own = sums.At(at, side, 0);
          if (own[kCount] < 0.5F) continue;
          cubes[CubeAt(size_, {i, j, k})] = {
              .mm = std::hypot(BoundMm(sums, strain_of_phase, h, at, side), kSmallestMm),
              .unseen_share = 1.0F - Mean(own, kSeen)};
        }
      }
    });
  }
}

ErrorBound::Cube ErrorBound::At(const Vector3f& at, Side side) const noexcept {
  Cube out;
  float total = 0.0F;
  AroundCubes(size_, at, 2, [&](std::size_t index, float weight) {
    const Cube& cube = cubes_[SideIndex(side)][index];
    if (cube.mm == 0.0F) return;
    // A little for cubes of weight 0, so that they serve where nothing else does.
    weight += 1e-6F;
    total += weight;
    out.mm += weight * cube.mm;
    out.unseen_share += weight * cube.unseen_share;
  });
  if (total == 0.0F) return {};
  return {.mm = out.mm / total, .unseen_share = out.unseen_share / total};
}

double ErrorBound::Mm(const Vector3f& at, Side side) const noexcept {
  return static_cast<double>(At(at, side).mm);
}

bool ErrorBound::IsUnseen(const Vector3f& at, Side side) const noexcept {
  return At(at, side).unseen_share > 1.0F - kSeenEnough;
}

}  // namespace acus::breathing_registration
