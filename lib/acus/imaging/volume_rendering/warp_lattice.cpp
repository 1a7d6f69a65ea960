#include "acus/imaging/volume_rendering/warp_lattice.h"

#include <cmath>

#include "acus/base/core/parallel.h"

namespace acus::volume_rendering {
namespace {

using Eigen::Array3i;
using Eigen::Vector3d;
using Eigen::Vector3f;

/// A knot that has no neighbour begins from nothing.
constexpr int kIterations = 20;
constexpr double kKnotToleranceMm = 0.01;
/// Where a block is judged: its middle, and the corners of a tetrahedron around it.
constexpr std::array<std::array<float, 3>, 5> kJudged = {{{0.5F, 0.5F, 0.5F},
                                                          {0.2F, 0.2F, 0.2F},
                                                          {0.8F, 0.8F, 0.2F},
                                                          {0.8F, 0.2F, 0.8F},
                                                          {0.2F, 0.8F, 0.8F}}};

}  // namespace

bool WarpLattice::TouchesVisible(const VisibleBlocks& blocks, const Array3i& knot) const noexcept {
  // Most knots are far from anything: blocks around this one are one step from it at most.
  if (blocks.DistanceOf(knot.min(size_ - 1)) > 1) return false;
  for (int n = 0; n < 8; ++n) {
    const Array3i block = knot - Array3i(n & 1, (n >> 1) & 1, n >> 2);
    if ((block < 0).any() || (block >= size_).any()) continue;
    if (blocks.DistanceOf(block) == 0) return true;
  }
  return false;
}

/// Row by row from the neighbour: what one knot gives does not depend on which thread comes by.
void WarpLattice::InvertSlice(const breathing::MotionMap& motion, const VisibleBlocks& blocks,
                              int k) {
  Knot* knot = knots_.data() + static_cast<std::ptrdiff_t>(k) * (size_[1] + 1) * (size_[0] + 1);
  for (int j = 0; j <= size_[1]; ++j) {
    Vector3d moved_mm = Vector3d::Zero();
    for (int i = 0; i <= size_[0]; ++i, ++knot) {
      if (!TouchesVisible(blocks, {i, j, k})) continue;
      const Vector3d place = ct_from_blocks_ * Vector3d(i, j, k);
      const auto found =
          motion.RestOf(place, place + moved_mm,
                        {.max_iterations = kIterations, .tolerance_mm = kKnotToleranceMm});
      moved_mm = found.rest_mm - place;
      knot->head<3>() = (index_from_mm_ * moved_mm).cast<float>();
      (*knot)[3] = 0.0F;
    }
  }
}

void WarpLattice::JudgeSlice(const breathing::MotionMap& motion, const VisibleBlocks& blocks,
                             int k) {
  std::array<int, 2>& count = counts_[static_cast<std::size_t>(k)];
  count = {0, 0};
  std::uint8_t* smooth = smooth_.data() + static_cast<std::ptrdiff_t>(k) * size_[1] * size_[0];
  for (int j = 0; j < size_[1]; ++j) {
    for (int i = 0; i < size_[0]; ++i, ++smooth) {
      const Array3i block(i, j, k);
      *smooth = 0;
      if (blocks.DistanceOf(block) != 0) continue;
      bool is_smooth = true;
      for (std::size_t n = 0; n < kJudged.size() && is_smooth; ++n) {
        const Vector3f at =
            block.cast<float>().matrix() + Vector3f(kJudged[n][0], kJudged[n][1], kJudged[n][2]);
        const Vector3d place = ct_from_blocks_ * at.cast<double>();
        const Vector3d rest = place + mm_from_index_ * OffsetAt(block, at).cast<double>();
        is_smooth = (rest + motion.DisplacementMm(rest) - place).squaredNorm() <=
                    tolerance_mm_ * tolerance_mm_;
      }
      *smooth = is_smooth ? 1 : 0;
      ++count[0];
      count[1] += is_smooth;
    }
  }
}

void WarpLattice::Update(const breathing::MotionMap& motion, const VisibleBlocks& blocks,
                         const Eigen::Affine3d& index_from_ct, double tolerance_mm,
                         int num_threads) {
  Clear();
  smooth_share_ = 0.0;
  if (!(tolerance_mm > 0.0) || !motion.moves() || blocks.nothing_visible()) return;
  size_ = blocks.size();
  tolerance_mm_ = tolerance_mm;
  ct_from_blocks_ = blocks.blocks_from_ct().cast<double>().inverse();
  index_from_mm_ = index_from_ct.linear();
  mm_from_index_ = index_from_mm_.inverse();
  knots_.resize(static_cast<std::size_t>((size_ + 1).cast<std::int64_t>().prod()));
  smooth_.resize(static_cast<std::size_t>(size_.cast<std::int64_t>().prod()));
  counts_.resize(static_cast<std::size_t>(size_[2]));
  ParallelFor(size_[2] + 1, num_threads, [&](int k) { InvertSlice(motion, blocks, k); });
  ParallelFor(size_[2], num_threads, [&](int k) { JudgeSlice(motion, blocks, k); });
  int visible = 0, smooth = 0;
  for (const std::array<int, 2>& count : counts_) {
    visible += count[0];
    smooth += count[1];
  }
  smooth_share_ = visible > 0 ? static_cast<double>(smooth) / visible : 0.0;
}

}  // namespace acus::volume_rendering
