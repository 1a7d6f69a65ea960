#include "acus/imaging/volume_rendering/visible_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "acus/base/core/error.h"

namespace acus::volume_rendering {
namespace {

constexpr double kBlockMm = 6.0;
constexpr int kLargestMargin = 40;
/// Farther than any distance that is used.
constexpr std::uint8_t kFarBlocks = 200;

}  // namespace

VisibleBlocks::VisibleBlocks(const volume::CtVolume& ct, const TransferFunction& transfer,
                             const breathing::MotionField* field, const TissueClasses& classes)
    : index_from_ct_(ct.geometry.index_from_ct()) {
  voxels_per_block_ = (kBlockMm / ct.geometry.spacing_mm).round().cast<int>().max(2).min(16);
  const Eigen::Vector3d blocks_per_voxel = voxels_per_block_.cast<double>().inverse();
  blocks_per_mm_ = (blocks_per_voxel.asDiagonal() * index_from_ct_.linear()).cast<float>();
  // One more: a block reaches from its first voxel to the first one of the next.
  rest_size_ = (ct.geometry.size + voxels_per_block_ - 1) / voxels_per_block_;
  FindVisible(ct, transfer, classes);
  if (field != nullptr) FindRanges(ct, *field);
}

void VisibleBlocks::FindVisible(const volume::CtVolume& ct, const TransferFunction& transfer,
                                const TissueClasses& classes) {
  const Eigen::Array3i& size = ct.geometry.size;
  const Eigen::Array3i last = size - 1;
  // Blocks -1 and beyond the end hold the step from air to the first voxel: the border shows too.
  for (int bk = -1; bk < rest_size_[2]; ++bk) {
    for (int bj = -1; bj < rest_size_[1]; ++bj) {
      for (int bi = -1; bi < rest_size_[0]; ++bi) {
        const Eigen::Array3i block(bi, bj, bk);
        const Eigen::Array3i first = block * voxels_per_block_;
        const Eigen::Array3i end = first + voxels_per_block_;
        const bool border = (first < 0).any() || (end > last).any();
        std::int16_t low = border ? std::int16_t{-1024} : std::numeric_limits<std::int16_t>::max();
        std::int16_t high =
            border ? std::int16_t{-1024} : std::numeric_limits<std::int16_t>::lowest();
        const Eigen::Array3i from = first.max(0);
        const Eigen::Array3i to = end.min(last);
        for (int k = from[2]; k <= to[2]; ++k) {
          for (int j = from[1]; j <= to[1]; ++j) {
            const std::int16_t* row = &ct.voxels[ct.geometry.Index(0, j, k)];
            for (int i = from[0]; i <= to[0]; ++i) {
              low = std::min(low, row[i]);
              high = std::max(high, row[i]);
            }
          }
        }
        if (transfer.Shows(low, high, classes.In(from, to))) visible_.push_back(block);
      }
    }
  }
}

void VisibleBlocks::FindRanges(const volume::CtVolume& ct, const breathing::MotionField& field) {
  num_components_ = field.num_components();
  ranges_mm_.resize(visible_.size() * static_cast<std::size_t>(num_components_));
  constexpr float kHuge = std::numeric_limits<float>::max();
  whole_ranges_mm_.assign(static_cast<std::size_t>(num_components_),
                          {Eigen::Array3f::Constant(kHuge), Eigen::Array3f::Constant(-kHuge)});
  const Eigen::Affine3d node_from_index =
      field.nodes().index_from_ct() * ct.geometry.ct_from_index();
  const Eigen::Array3i last = field.nodes().size - 1;
  std::size_t next = 0;
  for (const Eigen::Array3i& block : visible_) {
    Eigen::AlignedBox3d box;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Array3i at(corner & 1, (corner >> 1) & 1, corner >> 2);
      box.extend(node_from_index *
                 ((block + at) * voxels_per_block_).cast<double>().matrix().eval());
    }
    const Eigen::Array3i from = box.min().array().floor().cast<int>().max(0).min(last);
    const Eigen::Array3i to = box.max().array().ceil().cast<int>().max(0).min(last);
    for (int n = 0; n < num_components_; ++n) {
      Eigen::Array3i low = Eigen::Array3i::Constant(std::numeric_limits<int>::max());
      Eigen::Array3i high = -low;
      for (int k = from[2]; k <= to[2]; ++k) {
        for (int j = from[1]; j <= to[1]; ++j) {
          const std::int16_t* node =
              &field.StoredRow(n, j, k)[3 * static_cast<std::size_t>(from[0])];
          for (int i = from[0]; i <= to[0]; ++i, node += 3) {
            const Eigen::Array3i value(node[0], node[1], node[2]);
            low = low.min(value);
            high = high.max(value);
          }
        }
      }
      const auto unit_mm = static_cast<float>(field.MmPerUnit(n));
      const Range& range =
          ranges_mm_[next++] = {unit_mm * low.cast<float>(), unit_mm * high.cast<float>()};
      Range& whole = whole_ranges_mm_[static_cast<std::size_t>(n)];
      whole = {whole.low_mm.min(range.low_mm), whole.high_mm.max(range.high_mm)};
    }
  }
}

Eigen::AlignedBox3d VisibleBlocks::VisibleBox() const {
  Eigen::AlignedBox3d blocks;
  for (const Eigen::Array3i& block : visible_) {
    blocks.extend(block.cast<double>().matrix());
    blocks.extend((block + 1).cast<double>().matrix());
  }
  if (blocks.isEmpty()) blocks = {Eigen::Vector3d::Zero(), rest_size_.cast<double>().matrix()};
  const Eigen::Affine3d ct_from_index = index_from_ct_.inverse();
  Eigen::AlignedBox3d out;
  for (int n = 0; n < 8; ++n) {
    const Eigen::Vector3d corner = blocks.corner(static_cast<Eigen::AlignedBox3d::CornerType>(n));
    out.extend(ct_from_index *
               corner.cwiseProduct(voxels_per_block_.cast<double>().matrix()).cwiseMax(0.0).eval());
  }
  return out;
}

VisibleBlocks::Range VisibleBlocks::RangeNow(const Range* of_components,
                                             const breathing::MotionWeights& weights) {
  Range sum{Eigen::Array3f::Zero(), Eigen::Array3f::Zero()};
  for (std::size_t n = 0; n < static_cast<std::size_t>(weights.count); ++n) {
    const Range& range = of_components[weights.component[n]];
    const Eigen::Array3f low = weights.weight[n] * range.low_mm;
    const Eigen::Array3f high = weights.weight[n] * range.high_mm;
    sum.low_mm += low.min(high);
    sum.high_mm += low.max(high);
  }
  return sum;
}

BlockFrame VisibleBlocks::FrameFor(const breathing::MotionMap* motion, double ray_step_mm) const {
  BlockFrame frame;
  // A sample on either side of whatever is visible.
  frame.reach = static_cast<float>(ray_step_mm) * blocks_per_mm_.rowwise().norm().array() + 1e-3F;
  const Shift shift = ShiftOf(whole_ranges_mm_.data(), motion, frame.reach);
  const Eigen::Array3f farthest = shift.low.abs().max(shift.high.abs());
  frame.margin = (farthest.ceil().cast<int>() + 1).min(kLargestMargin);
  frame.size = rest_size_ + 1 + 2 * frame.margin;
  const Eigen::Array3d scale = voxels_per_block_.cast<double>().inverse();
  const Eigen::Affine3d blocks_from_index =
      Eigen::Translation3d((frame.margin + 1).cast<double>().matrix()) *
      Eigen::Scaling(scale.matrix());
  frame.blocks_from_ct = (blocks_from_index * index_from_ct_).cast<float>();
  return frame;
}

void VisibleBlocks::Mark(const Eigen::Array3i& low, const Eigen::Array3i& high) {
  const Eigen::Array3i from = low.max(0);
  const Eigen::Array3i to = high.min(frame_.size - 1);
  for (int k = from[2]; k <= to[2]; ++k) {
    for (int j = from[1]; j <= to[1]; ++j) {
      const auto row =
          distance_.begin() + static_cast<std::ptrdiff_t>(k * frame_.size[1] + j) * frame_.size[0];
      if (from[0] <= to[0]) std::fill(row + from[0], row + to[0] + 1, std::uint8_t{0});
    }
  }
}

/// Two sweeps with the 26 neighbours give the exact chessboard distance. Neighbours in other rows
/// come first, a whole row at a time; then those along the row.
void VisibleBlocks::SpreadDistance() {
  const std::ptrdiff_t row = frame_.size[0];
  const std::ptrdiff_t slice = row * frame_.size[1];
  std::vector<std::uint8_t> nearest(static_cast<std::size_t>(row) + 2);
  const auto sweep_row = [&](int j, int k, int sign) {
    std::ranges::fill(nearest, kFarBlocks);
    std::uint8_t* best = nearest.data() + 1;
    std::uint8_t* here = distance_.data() + slice * k + row * j;
    const auto add = [&](int dj, int dk) {
      const int j_other = j + sign * dj;
      const int k_other = k + sign * dk;
      if (j_other < 0 || j_other >= frame_.size[1] || k_other < 0 || k_other >= frame_.size[2])
        return;
      const std::uint8_t* other = distance_.data() + slice * k_other + row * j_other;
      for (std::ptrdiff_t i = 0; i < row; ++i) best[i] = std::min(best[i], other[i]);
    };
    add(-1, -1);
    add(0, -1);
    add(1, -1);
    add(-1, 0);
    for (std::ptrdiff_t i = 0; i < row; ++i) {
      const std::uint8_t of_rows = std::min({best[i - 1], best[i], best[i + 1]});
      here[i] = std::min(here[i], static_cast<std::uint8_t>(of_rows + 1));
    }
    for (std::ptrdiff_t n = 1; n < row; ++n) {
      const std::ptrdiff_t i = sign > 0 ? n : row - 1 - n;
      here[i] = std::min(here[i], static_cast<std::uint8_t>(here[i - sign] + 1));
    }
  };
  for (int k = 0; k < frame_.size[2]; ++k) {
    for (int j = 0; j < frame_.size[1]; ++j) sweep_row(j, k, 1);
  }
  for (int k = frame_.size[2] - 1; k >= 0; --k) {
    for (int j = frame_.size[1] - 1; j >= 0; --j) sweep_row(j, k, -1);
  }
}

VisibleBlocks::Shift VisibleBlocks::ShiftOf(const Range* of_components,
                                            const breathing::MotionMap* motion,
                                            const Eigen::Array3f& reach) const {
  if (motion == nullptr) return {-reach, reach};
  const Range mm = RangeNow(of_components, motion->weights());
  // Whichever way the volume's axes run.
  const Eigen::Array3f middle = blocks_per_mm_ * (0.5F * (mm.low_mm + mm.high_mm)).matrix();
  const Eigen::Array3f half =
      blocks_per_mm_.cwiseAbs() * (0.5F * (mm.high_mm - mm.low_mm)).matrix();
  // Farther than any grid reaches, and still a whole number.
  constexpr float kFar = 1e4F;
  return {(middle - half - reach).max(-kFar), (middle + half + reach).min(kFar)};
}

void VisibleBlocks::Widen(const Eigen::AlignedBox3f& box_in_ct_mm, float by_mm) {
  if (visible_.empty() || box_in_ct_mm.isEmpty()) return;
  const Eigen::AlignedBox3f blocks = box_in_ct_mm.transformed(frame_.blocks_from_ct);
  const Eigen::Array3i from = blocks.min().array().floor().cast<int>().max(0);
  const Eigen::Array3i to = blocks.max().array().ceil().cast<int>().min(frame_.size - 1);
  const auto reach =
      static_cast<int>(std::ceil((by_mm * blocks_per_mm_.rowwise().norm().array()).maxCoeff()));
  for (int k = from[2]; k <= to[2]; ++k) {
    for (int j = from[1]; j <= to[1]; ++j) {
      for (int i = from[0]; i <= to[0]; ++i) {
        std::uint8_t& distance =
            distance_[static_cast<std::size_t>((k * frame_.size[1] + j) * frame_.size[0] + i)];
        if (distance <= reach) distance = 0;
      }
    }
  }
  SpreadDistance();
  still_ = false;
}

void VisibleBlocks::Update(const breathing::MotionMap* motion, double ray_step_mm) {
  if (motion != nullptr && !motion->moves()) motion = nullptr;
  if (visible_.empty() || (motion == nullptr && still_ && step_mm_ == ray_step_mm)) return;
  ACUS_ASSERT(motion == nullptr || num_components_ == motion->field().num_components());
  frame_ = FrameFor(motion, ray_step_mm);
  // Read by four at a time.
  distance_.resize(static_cast<std::size_t>(frame_.size.cast<std::int64_t>().prod()) + 3);
  std::ranges::fill(distance_, kFarBlocks);
  const Range* ranges = ranges_mm_.data();
  for (const Eigen::Array3i& block : visible_) {
    const Shift shift = ShiftOf(ranges, motion, frame_.reach);
    ranges += num_components_;
    const Eigen::Array3f at = (block + 1 + frame_.margin).cast<float>();
    Mark((at + shift.low).floor().cast<int>(), (at + 1.0F + shift.high).floor().cast<int>());
  }
  SpreadDistance();
  still_ = motion == nullptr;
  step_mm_ = ray_step_mm;
}

}  // namespace acus::volume_rendering
