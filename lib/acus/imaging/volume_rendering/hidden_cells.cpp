#include "acus/imaging/volume_rendering/hidden_cells.h"

#include <algorithm>

namespace acus::volume_rendering {

HiddenCells::HiddenCells(const volume::CtVolume& ct, const TransferFunction& transfer,
                         const TissueClasses& classes) {
  const Eigen::Array3i cells = (ct.geometry.size - 1) / 2;
  end_ = (2 * cells).cast<float>();
  row_bits_ = (static_cast<std::size_t>(cells[0]) + 63) / 64 * 64;
  cells_j_ = static_cast<std::size_t>(cells[1]);
  hidden_.assign(row_bits_ / 64 * cells_j_ * static_cast<std::size_t>(cells[2]), 0);
  for (int k = 0; k < cells[2]; ++k) {
    for (int j = 0; j < cells[1]; ++j) {
      const std::size_t first =
          (static_cast<std::size_t>(k) * cells_j_ + static_cast<std::size_t>(j)) * row_bits_;
      for (int i = 0; i < cells[0]; ++i) {
        std::int16_t low = ct.At(2 * i, 2 * j, 2 * k);
        std::int16_t high = low;
        for (int n = 0; n < 9; ++n) {
          const std::int16_t* row =
              &ct.voxels[ct.geometry.Index(2 * i, 2 * j + n % 3, 2 * k + n / 3)];
          low = std::min({low, row[0], row[1], row[2]});
          high = std::max({high, row[0], row[1], row[2]});
        }
        const Eigen::Array3i first_voxel(2 * i, 2 * j, 2 * k);
        if (transfer.Shows(low, high, classes.In(first_voxel, first_voxel + 2))) continue;
        const std::size_t cell = first + static_cast<std::size_t>(i);
        hidden_[cell / 64] |= std::uint64_t{1} << (cell % 64);
      }
    }
  }
}

}  // namespace acus::volume_rendering
