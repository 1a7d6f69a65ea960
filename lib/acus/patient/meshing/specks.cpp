#include "acus/patient/meshing/specks.h"

#include <algorithm>
#include <array>
#include <functional>
#include <vector>

namespace acus::meshing {
namespace {

/// Voxels of one piece, and what they touch.
struct Piece {
  std::vector<std::size_t> voxels;
  std::array<std::size_t, 256> faces{};  ///< With voxels of that label outside the piece.
};

/// Goes through the pieces of voxels of one kind.
class Pieces {
 public:
  using Kind = std::array<std::uint8_t, 256>;  ///< By label.

  Pieces(const volume::LabelMap& labels, const Kind& kind)
      : labels_(labels), kind_(kind), is_seen_(labels.voxels.size(), 0) {
    const Eigen::Array3i& n = labels.geometry.size;
    step_ = {1, n[0], static_cast<std::ptrdiff_t>(n[0]) * n[1]};
  }

  void ForEach(const std::function<void(const Piece&)>& visit) {
    Piece piece;
    for (std::size_t seed = 0; seed < is_seen_.size(); ++seed) {
      if (is_seen_[seed] != 0) continue;
      Grow(seed, piece);
      visit(piece);
    }
  }

 private:
  void Grow(std::size_t seed, Piece& piece) {
    piece.voxels.assign(1, seed);
    piece.faces.fill(0);
    is_seen_[seed] = 1;
    const std::uint8_t kind = kind_[labels_.voxels[seed]];
    const Eigen::Array3i& size = labels_.geometry.size;
    for (std::size_t next = 0; next < piece.voxels.size(); ++next) {
      const std::size_t at = piece.voxels[next];
      const auto flat = static_cast<std::ptrdiff_t>(at);
      const std::array<std::ptrdiff_t, 3> index = {flat % size[0], flat / size[0] % size[1],
                                                   flat / step_[2]};
      for (std::size_t d = 0; d < 3; ++d) {
        for (const std::ptrdiff_t side : {-1, 1}) {
          const std::ptrdiff_t place = index[d] + side;
          if (place < 0 || place >= size[static_cast<Eigen::Index>(d)]) {
            ++piece.faces[0];
            continue;
          }
          const auto other = static_cast<std::size_t>(flat + side * step_[d]);
          const volume::Label label = labels_.voxels[other];
          if (kind_[label] != kind) {
            ++piece.faces[label];
          } else if (is_seen_[other] == 0) {
            is_seen_[other] = 1;
            piece.voxels.push_back(other);
          }
        }
      }
    }
  }

  const volume::LabelMap& labels_;
  const Kind& kind_;
  std::vector<std::uint8_t> is_seen_;
  std::array<std::ptrdiff_t, 3> step_;
};

}  // namespace

CleanedMap WithoutSpecks(const volume::LabelMap& labels, const MaterialOfLabel& material_of_label,
                         const SpeckLimits& limits) {
  CleanedMap out{.labels = labels};
  const double voxel_ml = labels.geometry.voxel_volume_mm3() / 1000.0;
  Pieces(labels, material_of_label).ForEach([&](const Piece& piece) {
    const double piece_ml = voxel_ml * static_cast<double>(piece.voxels.size());
    if (1000.0 * piece_ml >= limits.speck_mm3) return;
    const bool is_outside = labels.voxels[piece.voxels[0]] == 0;
    if (is_outside && piece.faces[0] > 0) return;  // Continues beyond the volume.
    const auto most = std::ranges::max_element(piece.faces) - piece.faces.begin();
    if (piece.faces[static_cast<std::size_t>(most)] == 0) return;  // There is nothing else.
    for (const std::size_t voxel : piece.voxels) {
      out.labels.voxels[voxel] = static_cast<volume::Label>(most);
    }
    out.specks_ml += piece_ml;
  });

  MaterialOfLabel is_body;
  is_body.fill(1);
  is_body[0] = 0;
  const auto body_voxels =
      static_cast<double>(out.labels.voxels.size() - static_cast<std::size_t>(std::ranges::count(
                                                         out.labels.voxels, volume::Label{0})));
  std::vector<std::size_t> removed;
  Pieces(out.labels, is_body).ForEach([&](const Piece& piece) {
    if (out.labels.voxels[piece.voxels[0]] == 0) return;
    if (static_cast<double>(piece.voxels.size()) >= limits.island_share * body_voxels) return;
    removed.insert(removed.end(), piece.voxels.begin(), piece.voxels.end());
  });
  for (const std::size_t voxel : removed) out.labels.voxels[voxel] = 0;
  out.islands_ml = voxel_ml * static_cast<double>(removed.size());
  return out;
}

}  // namespace acus::meshing
