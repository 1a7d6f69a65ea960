#include "acus/patient/meshing/interface_shape.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace acus::meshing {
namespace {

/// Faces between two materials in one block.
struct FacePatch {
  std::uint64_t key = 0;  ///< Block, then pair of materials.
  double count = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
};

constexpr std::uint64_t kPairs = 64 * 64;  ///< At most 64 materials: interface_cut.h.
constexpr double kFewestFaces = 4.0;       ///< Fewer lie in one plane anyhow.

/// Adds up the pieces with the same key; sorted by key.
void Merge(std::vector<FacePatch>& pieces) {
  std::ranges::stable_sort(pieces, {}, &FacePatch::key);
  std::size_t last = 0;
  for (std::size_t n = 1; n < pieces.size(); ++n) {
    if (pieces[n].key == pieces[last].key) {
      pieces[last].count += pieces[n].count;
      pieces[last].sum += pieces[n].sum;
      pieces[last].squares += pieces[n].squares;
    } else {
      pieces[++last] = pieces[n];
    }
  }
  if (!pieces.empty()) pieces.resize(last + 1);
}

double DistanceFromPlane(const FacePatch& piece) {
  if (piece.count < kFewestFaces) return 0.0;
  const Eigen::Vector3d mean = piece.sum / piece.count;
  const Eigen::Matrix3d covariance = piece.squares / piece.count - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
}

/// The faces between voxels of the field, by block of level 0.
std::vector<FacePatch> PiecesOf(const MaterialField& field, const BlockGrid& grid,
                                const Eigen::Array3d& unit_mm) {
  std::vector<FacePatch> out;
  const Eigen::Vector3i size = field.size();
  const Eigen::Vector3i blocks = grid.Size(0);
  Eigen::Vector3i v;
  for (v[2] = 0; v[2] < size[2]; ++v[2]) {
    const std::size_t slice = out.size();
    for (v[1] = 0; v[1] < size[1]; ++v[1]) {
      for (v[0] = 0; v[0] < size[0]; ++v[0]) {
        const std::uint64_t here = field.MaterialOfVoxel(v);
        for (int d = 0; d < 3; ++d) {
          if (v[d] + 1 >= size[d]) continue;
          const std::uint64_t there = field.MaterialOfVoxel(v + Eigen::Vector3i::Unit(d));
          if (here == there) continue;
          Eigen::Vector3d place = v.cast<double>();
          place[d] += 0.5;
          const Eigen::Vector3d x = field.low_mm() + place.cwiseProduct(field.spacing_mm());
          const Eigen::Vector3i block = ((x - grid.origin_mm) / grid.finest_mm)
                                            .array()
                                            .floor()
                                            .cast<int>()
                                            .max(0)
                                            .min(blocks.array() - 1);
          const Eigen::Vector3d scaled = x.array() / unit_mm;
          FacePatch piece;
          piece.key =
              grid.Index(0, block) * kPairs + std::min(here, there) * 64 + std::max(here, there);
          piece.count = 1.0;
          piece.sum = scaled;
          piece.squares = scaled * scaled.transpose();
          out.push_back(piece);
        }
      }
    }
    // Neighbours in a slice mostly share a block: what is kept stays small.
    std::vector<FacePatch> fresh(out.begin() + static_cast<std::ptrdiff_t>(slice), out.end());
    Merge(fresh);
    out.resize(slice);
    out.insert(out.end(), fresh.begin(), fresh.end());
  }
  Merge(out);
  return out;
}

}  // namespace

InterfaceShape::InterfaceShape(const MaterialField& field, const BlockGrid& grid,
                               const Eigen::Array3d& unit_mm)
    : roughness_(grid.top + 1) {
  std::vector<FacePatch> pieces = PiecesOf(field, grid, unit_mm);
  for (int level = 0; level <= grid.top; ++level) {
    const Eigen::Vector3i size = grid.Size(level);
    roughness_[level].assign(static_cast<std::size_t>(size.cast<double>().prod()), 0.0F);
    for (FacePatch& piece : pieces) {
      const std::uint64_t block = piece.key / kPairs;
      float& value = roughness_[level][block];
      value = std::max(value, static_cast<float>(DistanceFromPlane(piece)));
      if (level == grid.top) continue;
      const auto row = static_cast<std::uint64_t>(size[0]);
      const Eigen::Vector3i place(static_cast<int>(block % row),
                                  static_cast<int>(block / row % size[1]),
                                  static_cast<int>(block / (row * size[1])));
      piece.key = grid.Index(level + 1, place / 2) * kPairs + piece.key % kPairs;
    }
    Merge(pieces);
  }
}

}  // namespace acus::meshing
