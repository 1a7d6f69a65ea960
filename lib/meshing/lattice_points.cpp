#include "meshing/lattice_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/error.h"

namespace acus::meshing {
namespace {

using What = MaterialField::What;

double DistanceToSegment(const Eigen::Vector3d& x, const Corridor& corridor) {
  const Eigen::Vector3d along = corridor.to_mm - corridor.from_mm;
  const double t = std::clamp(
      (x - corridor.from_mm).dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
  return (x - corridor.from_mm - t * along).norm();
}

/// Blocks of all levels: level 0 is finest, a block of level k is 2^k finest blocks wide.
class Octree {
 public:
  Octree(const MaterialField& field, const ElementSizes& sizes) : field_(field), sizes_(sizes) {
    finest_ = std::min({sizes.interface_mm, sizes.skin_mm, sizes.interior_mm});
    if (sizes.corridor) finest_ = std::min(finest_, sizes.corridor->element_size_mm);
    const double ratio = sizes.interior_mm / finest_;
    top_ = std::clamp(static_cast<int>(std::floor(std::log2(ratio) + 1e-9)), 0, 6);
    const Eigen::Vector3d extent = field.high_mm() - field.low_mm();
    const double coarsest = finest_ * std::exp2(top_);
    double blocks = 1.0;
    for (int d = 0; d < 3; ++d) {
      top_size_[d] = static_cast<int>(std::ceil(extent[d] / coarsest));
      blocks *= static_cast<double>(top_size_[d]) * std::exp2(top_);
    }
    ACUS_REQUIRE(blocks < 4e8, "an element size of ", finest_, " mm over ", extent[0], " x ",
                 extent[1], " x ", extent[2], " mm is too fine; choose a larger one");
    origin_ = field.low_mm() - 0.5 * (top_size_.cast<double>() * coarsest - extent);
    Divide();
  }

  /// Calls visit(level, block) for each leaf, coarse to fine, in order of place.
  template <typename Visit>
  void ForEachLeaf(const Visit& visit) const {
    for (int level = top_; level >= 0; --level) {
      ForEachBlock(level, [&](const Eigen::Vector3i& block) {
        const bool exists = level == top_ || IsDivided(level + 1, block / 2);
        if (exists && !IsDivided(level, block)) visit(level, block);
      });
    }
  }

  Eigen::Vector3d Place(const Eigen::Vector3d& finest_blocks) const {
    return origin_ + finest_ * finest_blocks;
  }
  double SizeMm(int level) const { return finest_ * std::exp2(level); }

 private:
  Eigen::Vector3i Size(int level) const { return top_size_ * (1 << (top_ - level)); }

  template <typename Visit>
  void ForEachBlock(int level, const Visit& visit) const {
    const Eigen::Vector3i size = Size(level);
    Eigen::Vector3i block;
    for (block[2] = 0; block[2] < size[2]; ++block[2]) {
      for (block[1] = 0; block[1] < size[1]; ++block[1]) {
        for (block[0] = 0; block[0] < size[0]; ++block[0]) visit(block);
      }
    }
  }
  std::size_t Index(int level, const Eigen::Vector3i& b) const {
    const Eigen::Vector3i size = Size(level);
    return (static_cast<std::size_t>(b[2]) * size[1] + b[1]) * size[0] + b[0];
  }
  bool IsDivided(int level, const Eigen::Vector3i& block) const {
    return level > 0 && divided_[level][Index(level, block)] != 0;
  }

  /// Whether a block of this level is larger than what is wanted anywhere in it.
  bool IsTooLarge(int level, const Eigen::Vector3i& block) const {
    const double size = SizeMm(level);
    const double limit = 0.999 * size;
    const Eigen::Vector3d low = Place(block.cast<double>() * std::exp2(level));
    const Eigen::Vector3d high = low + Eigen::Vector3d::Constant(size);
    if (!field_.BoxHolds(low, high, What::kBody)) return false;
    if (sizes_.interior_mm < limit) return true;
    if (sizes_.skin_mm < limit && field_.BoxHolds(low, high, What::kSkin)) return true;
    if (sizes_.interface_mm < limit && field_.BoxHolds(low, high, What::kInterface)) return true;
    return sizes_.corridor && sizes_.corridor->element_size_mm < limit &&
           DistanceToSegment(0.5 * (low + high), *sizes_.corridor) <
               sizes_.corridor->radius_mm + 0.87 * size;
  }

  void Divide() {
    divided_.resize(top_ + 1);
    for (int level = 1; level <= top_; ++level) {
      divided_[level].assign(static_cast<std::size_t>(Size(level).cast<double>().prod()), 0);
      ForEachBlock(level, [&](const Eigen::Vector3i& block) {
        if (IsTooLarge(level, block)) divided_[level][Index(level, block)] = 1;
      });
      // Where a block one level finer is divided, all that touch it must exist at its own level.
      if (level == 1) continue;
      const Eigen::Vector3i finer_size = Size(level - 1);
      ForEachBlock(level - 1, [&](const Eigen::Vector3i& finer) {
        if (!IsDivided(level - 1, finer)) return;
        for (int n = 0; n < 27; ++n) {
          const Eigen::Vector3i next = finer + Eigen::Vector3i(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
          if ((next.array() < 0).any() || (next.array() >= finer_size.array()).any()) continue;
          divided_[level][Index(level, next / 2)] = 1;
        }
      });
    }
  }

  const MaterialField& field_;
  const ElementSizes& sizes_;
  double finest_ = 1.0;
  int top_ = 0;
  Eigen::Vector3i top_size_ = Eigen::Vector3i::Zero();
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  std::vector<std::vector<std::uint8_t>> divided_;  ///< By level, then block.
};

}  // namespace

Eigen::Matrix3Xd LatticePoints(const MaterialField& field, const ElementSizes& sizes,
                               std::size_t max_points) {
  const Octree octree(field, sizes);
  std::vector<std::array<int, 3>> halves;  // In halves of the finest block, to be whole numbers.
  octree.ForEachLeaf([&](int level, const Eigen::Vector3i& block) {
    const int width = 1 << level;
    const Eigen::Vector3i first = block * width;
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(1.01 * octree.SizeMm(level));
    if (!field.BoxHolds(octree.Place(first.cast<double>()) - margin,
                        octree.Place((first.array() + width).cast<double>()) + margin,
                        What::kBody)) {
      return;
    }
    for (int c = 0; c < 8; ++c) {
      halves.push_back({2 * (first[0] + (c & 1) * width), 2 * (first[1] + (c >> 1 & 1) * width),
                        2 * (first[2] + (c >> 2 & 1) * width)});
    }
    halves.push_back({2 * first[0] + width, 2 * first[1] + width, 2 * first[2] + width});
    ACUS_REQUIRE(halves.size() < 9 * max_points, "the mesh would have more than ", max_points,
                 " nodes; choose larger elements (element_size_mm) or a narrower corridor");
  });
  std::ranges::sort(halves);
  halves.erase(std::unique(halves.begin(), halves.end()), halves.end());
  Eigen::Matrix3Xd out(3, static_cast<Eigen::Index>(halves.size()));
  for (std::size_t n = 0; n < halves.size(); ++n) {
    out.col(static_cast<Eigen::Index>(n)) =
        octree.Place(0.5 * Eigen::Vector3d(halves[n][0], halves[n][1], halves[n][2]));
  }
  return out;
}

}  // namespace acus::meshing
