// Where nothing of the volume shows, in cells of two voxels each way: samples there need no voxel.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "acus/data/volume/volume.h"
#include "acus/imaging/volume_rendering/ray_kernel.h"
#include "acus/imaging/volume_rendering/transfer_function.h"

namespace acus::volume_rendering {

/// One bit a cell, so that those of a CT of 256^3 stay in a cache. Cells share the voxels on their
/// faces, so that a piece of ray between two hidden cells that touch shows nothing either: the
/// ranges of their values meet.
class HiddenCells {
 public:
  HiddenCells() = default;
  HiddenCells(const volume::CtVolume& ct, const TransferFunction& transfer,
              const TissueClasses& classes = {});

  /// @param index  A place at rest, in voxels. Outside the volume nothing is hidden: its border may
  ///     show.
  bool Hides(const Eigen::Vector3f& index) const noexcept {
    // Also false for a place that is not finite.
    if (!((index.array() >= 0.0F).all() && (index.array() < end_).all())) return false;
    const auto i = static_cast<std::size_t>(index[0]) >> 1U;
    const auto j = static_cast<std::size_t>(index[1]) >> 1U;
    const auto k = static_cast<std::size_t>(index[2]) >> 1U;
    const std::size_t cell = (k * cells_j_ + j) * row_bits_ + i;
    return (hidden_[cell >> 6U] >> (cell & 63U) & 1U) != 0;
  }

  /// For the kernel; as long as this lives.
  kernels::CellBits bits() const noexcept {
    return {.bits = hidden_.empty() ? nullptr : hidden_.data(),
            .end = {end_[0], end_[1], end_[2]},
            .row_bits = static_cast<std::int32_t>(row_bits_),
            .rows = static_cast<std::int32_t>(cells_j_)};
  }

 private:
  Eigen::Array3f end_ = Eigen::Array3f::Zero();  ///< In voxels; no cell is whole beyond.
  std::size_t row_bits_ = 0;                     ///< Cells along i, to whole words.
  std::size_t cells_j_ = 0;
  std::vector<std::uint64_t> hidden_;
};

}  // namespace acus::volume_rendering
