#include "acus/imaging/volume_rendering/warp_lattice.h"

#include <algorithm>
#include <array>
#include <limits>

#include "acus/base/core/parallel.h"
#include "acus/physics/breathing/moved_points.h"

namespace acus::volume_rendering {
namespace {

using Eigen::Array3i;
using Eigen::Vector3f;

/// A knot that has no neighbour begins from nothing.
constexpr int kIterations = 20;
constexpr float kKnotToleranceMm = 0.01F;
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

/// All knots of a slice together: from x - u(x), X <- x - u(X). Where that has not converged, the
/// knot is inverted with steps that are halved.
void WarpLattice::InvertSlice(const breathing::MotionMap& motion, const VisibleBlocks& blocks,
                              int k) {
  Slice& slice = slices_[static_cast<std::size_t>(k)];
  slice.number.clear();
  for (int j = 0; j <= size_[1]; ++j) {
    for (int i = 0; i <= size_[0]; ++i) {
      if (TouchesVisible(blocks, {i, j, k})) slice.number.push_back(j * (size_[0] + 1) + i);
    }
  }
  const auto count = static_cast<Eigen::Index>(slice.number.size());
  if (count == 0) return;
  for (auto* points : {&slice.place_mm, &slice.rest_mm, &slice.moved_mm}) points->resize(3, count);
  for (Eigen::Index n = 0; n < count; ++n) {
    const int number = slice.number[static_cast<std::size_t>(n)];
    slice.place_mm.col(n) =
        ct_from_blocks_ *
        Array3i(number % (size_[0] + 1), number / (size_[0] + 1), k).cast<float>().matrix();
  }
  slice.rest_mm = slice.place_mm;
  float off_mm = std::numeric_limits<float>::max();
  for (int n = 0; n < kIterations && off_mm > kKnotToleranceMm; ++n) {
    breathing::DisplacementsMm(motion, slice.rest_mm, slice.moved_mm);
    // |X+ - X| is |X + u(X) - x|.
    slice.moved_mm = slice.place_mm - slice.moved_mm;
    off_mm = (slice.moved_mm - slice.rest_mm).cwiseAbs().maxCoeff();
    slice.rest_mm.swap(slice.moved_mm);
  }
  Knot* knots = knots_.data() + static_cast<std::ptrdiff_t>(k) * (size_[1] + 1) * (size_[0] + 1);
  for (Eigen::Index n = 0; n < count; ++n) {
    Vector3f rest_mm = slice.rest_mm.col(n);
    const Vector3f place_mm = slice.place_mm.col(n);
    if (!((rest_mm - slice.moved_mm.col(n)).squaredNorm() <= kKnotToleranceMm * kKnotToleranceMm)) {
      rest_mm = motion
                    .RestOf(place_mm.cast<double>(), place_mm.cast<double>(),
                            {.max_iterations = kIterations, .tolerance_mm = kKnotToleranceMm})
                    .rest_mm.cast<float>();
    }
    Knot& knot = knots[slice.number[static_cast<std::size_t>(n)]];
    knot.head<3>() = index_from_mm_ * (rest_mm - place_mm);
    knot[3] = 0.0F;
  }
}

void WarpLattice::JudgeSlice(const breathing::MotionMap& motion, const VisibleBlocks& blocks,
                             int k) {
  Slice& slice = slices_[static_cast<std::size_t>(k)];
  slice.number.clear();
  std::uint8_t* smooth = smooth_.data() + static_cast<std::ptrdiff_t>(k) * size_[1] * size_[0];
  std::fill_n(smooth, size_[1] * size_[0], std::uint8_t{0});
  for (int j = 0; j < size_[1]; ++j) {
    for (int i = 0; i < size_[0]; ++i) {
      if (blocks.DistanceOf({i, j, k}) == 0) slice.number.push_back(j * size_[0] + i);
    }
  }
  slice.num_visible = static_cast<int>(slice.number.size());
  slice.num_smooth = 0;
  if (slice.num_visible == 0) return;
  constexpr auto kPlaces = static_cast<Eigen::Index>(kJudged.size());
  const Eigen::Index count = kPlaces * slice.num_visible;
  for (auto* points : {&slice.place_mm, &slice.rest_mm, &slice.moved_mm}) points->resize(3, count);
  for (Eigen::Index n = 0; n < count; ++n) {
    const int number = slice.number[static_cast<std::size_t>(n / kPlaces)];
    const auto& share = kJudged[static_cast<std::size_t>(n % kPlaces)];
    const Array3i block(number % size_[0], number / size_[0], k);
    const Vector3f at = block.cast<float>().matrix() + Vector3f(share[0], share[1], share[2]);
    slice.place_mm.col(n) = ct_from_blocks_ * at;
    slice.rest_mm.col(n) = slice.place_mm.col(n) + mm_from_index_ * OffsetAt(block, at);
  }
  breathing::DisplacementsMm(motion, slice.rest_mm, slice.moved_mm);
  const auto tolerance_mm = static_cast<float>(tolerance_mm_);
  for (int n = 0; n < slice.num_visible; ++n) {
    bool is_smooth = true;
    for (Eigen::Index at = kPlaces * n; at < kPlaces * (n + 1); ++at) {
      const Vector3f off = slice.rest_mm.col(at) + slice.moved_mm.col(at) - slice.place_mm.col(at);
      is_smooth = is_smooth && off.squaredNorm() <= tolerance_mm * tolerance_mm;
    }
    smooth[slice.number[static_cast<std::size_t>(n)]] = is_smooth ? 1 : 0;
    slice.num_smooth += is_smooth;
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
  ct_from_blocks_ = blocks.blocks_from_ct().cast<double>().inverse().cast<float>();
  index_from_mm_ = index_from_ct.linear().cast<float>();
  mm_from_index_ = index_from_ct.linear().inverse().cast<float>();
  knots_.resize(static_cast<std::size_t>((size_ + 1).cast<std::int64_t>().prod()));
  smooth_.resize(static_cast<std::size_t>(size_.cast<std::int64_t>().prod()));
  slices_.resize(static_cast<std::size_t>(size_[2]) + 1);
  ParallelFor(size_[2] + 1, num_threads, [&](int k) { InvertSlice(motion, blocks, k); });
  ParallelFor(size_[2], num_threads, [&](int k) { JudgeSlice(motion, blocks, k); });
  int visible = 0, smooth = 0;
  for (int k = 0; k < size_[2]; ++k) {
    visible += slices_[static_cast<std::size_t>(k)].num_visible;
    smooth += slices_[static_cast<std::size_t>(k)].num_smooth;
  }
  smooth_share_ = visible > 0 ? static_cast<double>(smooth) / visible : 0.0;
}

}  // namespace acus::volume_rendering
