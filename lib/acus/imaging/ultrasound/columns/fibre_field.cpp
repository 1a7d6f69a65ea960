#include "acus/imaging/ultrasound/columns/fibre_field.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>

namespace acus::ultrasound {
namespace {

/// Blocks to each side that a direction is taken from.
constexpr int kReachVoxels = 2;

/// Towards the outside of `label`, in voxel axes scaled to mm; zero inside it. All 26 neighbours
/// count, so that steps of the voxels are rounded off.
Eigen::Vector3d NormalMm(const volume::LabelMap& labels, volume::Label label, int i, int j, int k) {
  const auto& g = labels.geometry;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int dk = -1; dk <= 1; ++dk) {
    for (int dj = -1; dj <= 1; ++dj) {
      for (int di = -1; di <= 1; ++di) {
        if (!g.Contains(i + di, j + dj, k + dk)) continue;
        if (labels.At(i + di, j + dj, k + dk) == label) continue;
        const Eigen::Vector3d way = (Eigen::Array3d(di, dj, dk) * g.spacing_mm).matrix();
        sum += way / way.squaredNorm();
      }
    }
  }
  return sum;
}

/// Eigenvector of the smallest eigenvalue.
Eigen::Vector3d LeastChange(const Eigen::Matrix3d& tensor) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(tensor);
  return solver.eigenvectors().col(0);
}

/// Sums over 2 kReachVoxels + 1 adjacent voxels along one axis.
void SumAlong(const Eigen::Array3i& size, int axis, std::vector<Eigen::Matrix3d>& values) {
  const std::array<int, 3> stride = {1, size[0], size[0] * size[1]};
  const int step = stride[static_cast<std::size_t>(axis)];
  std::vector<Eigen::Matrix3d> line(static_cast<std::size_t>(size[axis]));
  for (int start = 0; start < static_cast<int>(values.size()); ++start) {
    if (start / step % size[axis] != 0) continue;
    for (int n = 0; n < size[axis]; ++n) {
      line[static_cast<std::size_t>(n)] = Eigen::Matrix3d::Zero();
      for (int m = std::max(0, n - kReachVoxels); m <= std::min(size[axis] - 1, n + kReachVoxels);
           ++m) {
        line[static_cast<std::size_t>(n)] += values[static_cast<std::size_t>(start + m * step)];
      }
    }
    for (int n = 0; n < size[axis]; ++n) {
      values[static_cast<std::size_t>(start + n * step)] = line[static_cast<std::size_t>(n)];
    }
  }
}

}  // namespace

FibreField::FibreField(const volume::LabelMap& labels, const std::bitset<256>& fibrous,
                       double block_mm) {
  const auto& g = labels.geometry;
  std::array<Eigen::Array3i, 256> low;
  std::array<Eigen::Array3i, 256> high;
  low.fill(g.size);
  high.fill(Eigen::Array3i::Constant(-1));
  std::size_t n = 0;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i, ++n) {
        const volume::Label label = labels.voxels[n];
        if (!fibrous[label]) continue;
        low[label] = low[label].min(Eigen::Array3i(i, j, k));
        high[label] = high[label].max(Eigen::Array3i(i, j, k));
      }
    }
  }
  for (int label = 0; label < 256; ++label) {
    const auto l = static_cast<std::size_t>(label);
    if (high[l][0] < 0) continue;
    const auto name = static_cast<volume::Label>(label);
    blocks_[name] = BlocksOf(labels, name, low[l], high[l], block_mm);
  }
}

FibreField::Blocks FibreField::BlocksOf(const volume::LabelMap& labels, volume::Label label,
                                        const Eigen::Array3i& low, const Eigen::Array3i& high,
                                        double block_mm) {
  const auto& g = labels.geometry;
  Blocks blocks;
  blocks.first_index = low.cast<float>() - 0.5F;
  blocks.per_index = (g.spacing_mm / block_mm).cast<float>();
  const Eigen::Array3d extent_mm = (high - low + 1).cast<double>() * g.spacing_mm;
  blocks.size = (extent_mm / block_mm).ceil().cast<int>().max(1);
  const auto count = static_cast<std::size_t>(blocks.size.prod());
  std::vector<Eigen::Matrix3d> tensor(count, Eigen::Matrix3d::Zero());
  Eigen::Matrix3d whole = Eigen::Matrix3d::Zero();
  for (int k = low[2]; k <= high[2]; ++k) {
    for (int j = low[1]; j <= high[1]; ++j) {
      for (int i = low[0]; i <= high[0]; ++i) {
        if (labels.At(i, j, k) != label) continue;
        const Eigen::Vector3d normal = NormalMm(labels, label, i, j, k);
        const double length = normal.norm();
        if (length < 1e-9) continue;
        const Eigen::Matrix3d share = normal * normal.transpose() / (length * length);
        const Eigen::Array3f place =
            (Eigen::Array3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k)) -
             blocks.first_index) *
            blocks.per_index;
        const Eigen::Array3i at = place.cast<int>().min(blocks.size - 1);
        tensor[static_cast<std::size_t>((at[2] * blocks.size[1] + at[1]) * blocks.size[0] +
                                        at[0])] += share;
        whole += share;
      }
    }
  }
  for (int axis = 0; axis < 3; ++axis) SumAlong(blocks.size, axis, tensor);
  const Eigen::Vector3d main = g.direction * LeastChange(whole);
  blocks.main = main.cast<float>();
  blocks.direction.resize(count);
  for (std::size_t b = 0; b < count; ++b) {
    Eigen::Vector3d direction = main;
    if (tensor[b].trace() > 0.0) direction = g.direction * LeastChange(tensor[b]);
    if (direction.dot(main) < 0.0) direction = -direction;
    blocks.direction[b] = direction.cast<float>();
  }
  return blocks;
}

Eigen::Vector3f FibreField::At(volume::Label label, const Eigen::Vector3f& index) const {
  const auto found = blocks_.find(label);
  if (found == blocks_.end()) return Eigen::Vector3f::Zero();
  const Blocks& b = found->second;
  const Eigen::Array3f place = (index.array() - b.first_index) * b.per_index;
  const Eigen::Array3i at = place.max(0.0F).min((b.size - 1).cast<float>()).cast<int>();
  return b.direction[static_cast<std::size_t>((at[2] * b.size[1] + at[1]) * b.size[0] + at[0])];
}

Eigen::Vector3f FibreField::MainDirection(volume::Label label) const {
  const auto found = blocks_.find(label);
  return found == blocks_.end() ? Eigen::Vector3f::Zero() : found->second.main;
}

}  // namespace acus::ultrasound
