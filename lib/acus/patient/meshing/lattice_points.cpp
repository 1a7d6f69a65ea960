#include "acus/patient/meshing/lattice_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "acus/base/core/error.h"

namespace acus::meshing {
namespace {

using What = MaterialField::What;

double DistanceToSegment(const Eigen::Vector3d& x, const Corridor& corridor) {
  const Eigen::Vector3d along = corridor.to_mm - corridor.from_mm;
  const double t = std::clamp(
      (x - corridor.from_mm).dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
  return (x - corridor.from_mm - t * along).norm();
}

/// Blocks that are divided until each is as small as is required there.
class Octree {
 public:
  Octree(const MaterialField& field, const ElementSizes& sizes, const ShapeLimit& limit)
      : field_(field), sizes_(sizes), limit_(limit), grid_(BlocksOf(field, sizes)) {
    Divide();
  }

  /// Calls visit(level, block) for each leaf, coarse to fine, in order of place.
  template <typename Visit>
  void ForEachLeaf(const Visit& visit) const {
    for (int level = grid_.top; level >= 0; --level) {
      ForEachBlock(level, [&](const Eigen::Vector3i& block) {
        const bool exists = level == grid_.top || IsDivided(level + 1, block / 2);
        if (exists && !IsDivided(level, block)) visit(level, block);
      });
    }
  }

  Eigen::Vector3d Place(const Eigen::Vector3d& finest_blocks) const {
    return grid_.origin_mm + grid_.finest_mm * finest_blocks;
  }
  double SizeMm(int level) const { return grid_.finest_mm * std::exp2(level); }

 private:
  template <typename Visit>
  void ForEachBlock(int level, const Visit& visit) const {
    const Eigen::Vector3i size = grid_.Size(level);
    Eigen::Vector3i block;
    for (block[2] = 0; block[2] < size[2]; ++block[2]) {
      for (block[1] = 0; block[1] < size[1]; ++block[1]) {
        for (block[0] = 0; block[0] < size[0]; ++block[0]) visit(block);
      }
    }
  }
  bool IsDivided(int level, const Eigen::Vector3i& block) const {
    return level > 0 && divided_[level][grid_.Index(level, block)] != 0;
  }

  /// Whether a block of this level is larger than what is required anywhere in it.
  bool IsTooLarge(int level, const Eigen::Vector3i& block) const {
    const double size = SizeMm(level);
    const double limit = 0.999 * size;
    const Eigen::Vector3d low = Place(block.cast<double>() * std::exp2(level));
    const Eigen::Vector3d high = low + Eigen::Vector3d::Constant(size);
    if (!field_.BoxHolds(low, high, What::kBody)) return false;
    if (sizes_.interior_mm < limit) return true;
    if (sizes_.skin_mm < limit && field_.BoxHolds(low, high, What::kSkin)) return true;
    if (sizes_.interface_mm < limit && field_.BoxHolds(low, high, What::kInterface)) return true;
    if (limit_.shape != nullptr &&
        size * limit_.shape->Roughness(level, grid_.Index(level, block)) > limit_.gain_mm) {
      return true;
    }
    return sizes_.corridor && sizes_.corridor->element_size_mm < limit &&
           DistanceToSegment(0.5 * (low + high), *sizes_.corridor) <
               sizes_.corridor->radius_mm + 0.87 * size;
  }

  void Divide() {
    divided_.resize(grid_.top + 1);
    for (int level = 1; level <= grid_.top; ++level) {
      divided_[level].assign(static_cast<std::size_t>(grid_.Size(level).cast<double>().prod()), 0);
      ForEachBlock(level, [&](const Eigen::Vector3i& block) {
        if (IsTooLarge(level, block)) divided_[level][grid_.Index(level, block)] = 1;
      });
      // Where a block one level finer is divided, all that touch it must exist at its own level.
      if (level == 1) continue;
      const Eigen::Vector3i finer_size = grid_.Size(level - 1);
      ForEachBlock(level - 1, [&](const Eigen::Vector3i& finer) {
        if (!IsDivided(level - 1, finer)) return;
        for (int n = 0; n < 27; ++n) {
          const Eigen::Vector3i next = finer + Eigen::Vector3i(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
          if ((next.array() < 0).any() || (next.array() >= finer_size.array()).any()) continue;
          divided_[level][grid_.Index(level, next / 2)] = 1;
        }
      });
    }
  }

  const MaterialField& field_;
  const ElementSizes& sizes_;
  const ShapeLimit& limit_;
  BlockGrid grid_;
  std::vector<std::vector<std::uint8_t>> divided_;  ///< By level, then block.
};

}  // namespace

BlockGrid BlocksOf(const MaterialField& field, const ElementSizes& sizes) {
  BlockGrid out;
  double& finest = out.finest_mm;
  finest = std::min({sizes.interface_mm, sizes.skin_mm, sizes.interior_mm});
  if (sizes.corridor) finest = std::min(finest, sizes.corridor->element_size_mm);
  if (sizes.finest_mm > 0.0) finest = std::min(finest, sizes.finest_mm);
  const double ratio = sizes.interior_mm / finest;
  out.top = std::clamp(static_cast<int>(std::floor(std::log2(ratio) + 1e-9)), 0, 6);
  const Eigen::Vector3d extent = field.high_mm() - field.low_mm();
  const double coarsest = finest * std::exp2(out.top);
  double blocks = 1.0;
  for (int d = 0; d < 3; ++d) {
    out.top_size[d] = static_cast<int>(std::ceil(extent[d] / coarsest));
    blocks *= static_cast<double>(out.top_size[d]) * std::exp2(out.top);
  }
  ACUS_REQUIRE(blocks < 4e8, "an element size of ", finest, " mm over ", extent[0], " x ",
               extent[1], " x ", extent[2], " mm is too fine; choose a larger one");
  out.origin_mm = field.low_mm() - 0.5 * (out.top_size.cast<double>() * coarsest - extent);
  return out;
}

Eigen::Matrix3Xd LatticePoints(const MaterialField& field, const ElementSizes& sizes,
                               const ShapeLimit& limit, std::size_t max_points) {
  const Octree octree(field, sizes, limit);
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
