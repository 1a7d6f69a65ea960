#include "acus/imaging/ultrasound/beams/acoustic_volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "acus/base/core/parallel.h"
#include "acus/imaging/ultrasound/beams/organ_structure.h"
#include "acus/imaging/ultrasound/columns/ct_texture.h"
#include "acus/imaging/ultrasound/speckle/binomial_window.h"

namespace acus::ultrasound {
namespace {

/// From gas to metal: beyond, an interface reflects nearly all in any case.
constexpr float kLowestZeta = -1.2F;
constexpr float kHighestZeta = 1.2F;
/// Slices that one piece of work packs.
constexpr int kSlicesPerPiece = 16;

/// Values of one slice of the box.
struct Slice {
  std::array<std::vector<float>, 3> value;  ///< zeta, two-way nepers per mm, scatter.

  void Resize(std::size_t count) {
    for (auto& v : value) v.resize(count);
  }
};

/// Reads the acoustic values of voxels, before any smoothing.
class VoxelReader {
 public:
  VoxelReader(const BeamTissue& tissue, const BeamMaterials& per_mm, const CtTexture* texture,
              const OrganStructure* organs)
      : tissue_(tissue), materials_(per_mm), texture_(texture), organs_(organs) {
    const kernels::LabelTables tables = per_mm.label_tables();
    for (std::size_t n = 0; n < 256; ++n) {
      label_values_[0][n] = std::clamp(tables.log_impedance[n], kLowestZeta, kHighestZeta);
      label_values_[1][n] = -std::log(std::max(tables.decay[n], 1e-30F));
      label_values_[2][n] = tables.scatter[n];
    }
  }

  const volume::Geometry& geometry() const {
    return tissue_.labels != nullptr ? tissue_.labels->geometry : tissue_.ct->geometry;
  }

  /// Whether sound meets anything but air or what lies around the patient.
  bool IsTissue(std::size_t voxel) const {
    const int label = LabelAt(voxel);
    if (label == 0 && tissue_.ct != nullptr) return tissue_.ct->voxels[voxel] > kAirHu;
    return label != 0;
  }

  void ReadRow(std::size_t first_voxel, int count, const std::array<float*, 3>& out) {
    int by_hu = 0;
    for (int x = 0; x < count; ++x) {
      const std::size_t voxel = first_voxel + static_cast<std::size_t>(x);
      const int label = LabelAt(voxel);
      by_hu += label == 0 ? 1 : 0;
      for (std::size_t v = 0; v < 3; ++v) {
        out[v][x] = label_values_[v][static_cast<std::size_t>(label)];
      }
    }
    if (by_hu > 0 && tissue_.ct != nullptr) FillByHu(first_voxel, count, out);
    if (texture_ != nullptr) {
      for (int x = 0; x < count; ++x) {
        out[2][x] *= texture_->GainAt(first_voxel + static_cast<std::size_t>(x));
      }
    }
    for (int x = 0; organs_ != nullptr && x < count; ++x) {
      const std::size_t voxel = first_voxel + static_cast<std::size_t>(x);
      out[0][x] += organs_->ZetaAt(voxel);
      out[2][x] *= organs_->GainAt(voxel);
    }
  }

 private:
  static constexpr int kAirHu = -400;

  int LabelAt(std::size_t voxel) const {
    return tissue_.labels != nullptr ? tissue_.labels->voxels[voxel] : 0;
  }

  void FillByHu(std::size_t first_voxel, int count, const std::array<float*, 3>& out) {
    const int lanes = kernels::RoundUp(count);
    for (image::AlignedFloats* row : {&hu_, &zeta_, &decay_, &scatter_}) {
      row->Reserve(static_cast<std::size_t>(lanes));
    }
    for (int x = 0; x < lanes; ++x) {
      const std::size_t voxel = first_voxel + static_cast<std::size_t>(std::min(x, count - 1));
      hu_.data()[x] = tissue_.ct->voxels[voxel];
    }
    kernels::TissueOfHuRow(materials_.hu_curves(), hu_.data(), lanes,
                           {zeta_.data(), decay_.data(), scatter_.data()});
    for (int x = 0; x < count; ++x) {
      if (LabelAt(first_voxel + static_cast<std::size_t>(x)) != 0) continue;
      out[0][x] = std::clamp(zeta_.data()[x], kLowestZeta, kHighestZeta);
      out[1][x] = -std::log(std::max(decay_.data()[x], 1e-30F));
      out[2][x] = scatter_.data()[x];
    }
  }

  const BeamTissue& tissue_;
  const BeamMaterials& materials_;
  const CtTexture* texture_;
  const OrganStructure* organs_;
  std::array<std::array<float, 256>, 3> label_values_{};
  image::AlignedFloats hu_;
  image::AlignedFloats zeta_;
  image::AlignedFloats decay_;
  image::AlignedFloats scatter_;
};

/// The smallest box that holds all tissue and the reach of the window around it; all of the grid if
/// there is none. Two voxels at least along each axis, if the grid has them.
void FindBox(const VoxelReader& reader, Eigen::Array3i& first, Eigen::Array3i& size) {
  const Eigen::Array3i grid = reader.geometry().size;
  Eigen::Array3i low = grid;
  Eigen::Array3i high = Eigen::Array3i::Constant(-1);
  std::size_t n = 0;
  for (int k = 0; k < grid[2]; ++k) {
    for (int j = 0; j < grid[1]; ++j, n += static_cast<std::size_t>(grid[0])) {
      int a = 0;
      while (a < grid[0] && !reader.IsTissue(n + static_cast<std::size_t>(a))) ++a;
      if (a == grid[0]) continue;
      int b = grid[0] - 1;
      while (!reader.IsTissue(n + static_cast<std::size_t>(b))) --b;
      low = low.min(Eigen::Array3i(a, j, k));
      high = high.max(Eigen::Array3i(b, j, k));
    }
  }
  constexpr int kMargin = kBinomialReach + 2;
  if (high[0] < 0) {
    low.setZero();
    high = grid - 1;
  }
  first = (low - kMargin).max(0).min((grid - 2).max(0));
  size = (high + kMargin + 1).min(grid) - first;
}

/// Rounds to the nearest code.
std::uint32_t Code(float scaled, std::uint32_t codes) {
  return static_cast<std::uint32_t>(
      std::min(std::max(scaled + 0.5F, 0.0F), static_cast<float>(codes - 1)));
}

}  // namespace

AcousticVolume::AcousticVolume(const BeamTissue& tissue, const BeamMaterials& per_mm, bool texture,
                               int num_threads, std::optional<std::uint64_t> organs) {
  std::optional<CtTexture> ct_texture;
  if (texture && tissue.ct != nullptr && tissue.labels != nullptr) {
    ct_texture.emplace(*tissue.ct, *tissue.labels, num_threads);
  }
  const CtTexture* const gains = ct_texture ? &*ct_texture : nullptr;
  std::optional<OrganStructure> organ_structure;
  if (organs && tissue.labels != nullptr) organ_structure.emplace(*tissue.labels, *organs);
  const OrganStructure* const structure = organ_structure ? &*organ_structure : nullptr;
  const VoxelReader reader(tissue, per_mm, gains, structure);
  const volume::Geometry& geometry = reader.geometry();
  FindBox(reader, first_, size_);
  per_spacing_mm_ = geometry.spacing_mm.inverse().cast<float>();

  // Bone and gas lose far more than a code can hold; what they lose beyond is `strong`
  // (AddLossRow).
  constexpr float kMostNepersPerMm = 0.5F;
  const float most_scatter =
      per_mm.MostScatter() * (gains != nullptr ? CtTexture::kMostGain : 1.0F);
  view_.zeta_first = kLowestZeta;
  view_.zeta_unit = (kHighestZeta - kLowestZeta) / (kernels::kZetaCodes - 1);
  view_.nepers_unit = kMostNepersPerMm / (kernels::kNepersCodes - 1);
  view_.scatter_unit = std::max(most_scatter, 1e-12F) / (kernels::kScatterCodes - 1);

  const float per_zeta = 1.0F / view_.zeta_unit;
  const float per_neper = 1.0F / view_.nepers_unit;
  const float per_scatter = 1.0F / view_.scatter_unit;

  // The kernel reads pairs of voxels along each axis: a single one is doubled.
  const Eigen::Array3i stored = size_.max(2);
  const auto plane = static_cast<std::size_t>(stored[0]) * static_cast<std::size_t>(stored[1]);
  packed_.resize(plane * static_cast<std::size_t>(stored[2]));
  const auto pack = [&](const Slice& smooth, int k) {
    std::uint32_t* out = packed_.data() + static_cast<std::size_t>(k) * plane;
    for (int j = 0; j < stored[1]; ++j) {
      const auto row = static_cast<std::size_t>(std::min(j, size_[1] - 1)) * size_[0];
      for (int i = 0; i < stored[0]; ++i) {
        const std::size_t n = row + static_cast<std::size_t>(std::min(i, size_[0] - 1));
        *out++ = Code((smooth.value[0][n] - kLowestZeta) * per_zeta, kernels::kZetaCodes) << 20 |
                 Code(smooth.value[1][n] * per_neper, kernels::kNepersCodes) << 10 |
                 Code(smooth.value[2][n] * per_scatter, kernels::kScatterCodes);
      }
    }
  };
  const int pieces = (size_[2] + kSlicesPerPiece - 1) / kSlicesPerPiece;
  ParallelFor(pieces, num_threads, [&](int piece) {
    VoxelReader rows(tissue, per_mm, gains, structure);
    std::array<Slice, 5> ring;
    Slice smooth;
    for (Slice& slice : ring) slice.Resize(static_cast<std::size_t>(size_[0]) * size_[1]);
    smooth.Resize(ring[0].value[0].size());
    std::vector<float> scratch;
    const auto read = [&](int k) {
      Slice& slice = ring[RingSlot(k)];
      const int inside = std::clamp(k, 0, size_[2] - 1) + first_[2];
      for (int j = 0; j < size_[1]; ++j) {
        const auto at = static_cast<std::ptrdiff_t>(j) * size_[0];
        rows.ReadRow(
            geometry.Index(first_[0], first_[1] + j, inside), size_[0],
            {slice.value[0].data() + at, slice.value[1].data() + at, slice.value[2].data() + at});
      }
      for (auto& value : slice.value) SmoothSlice(value, size_[0], size_[1], scratch);
    };
    const int first = piece * kSlicesPerPiece;
    const int end = std::min(size_[2], first + kSlicesPerPiece);
    for (int k = first - kBinomialReach; k < first + kBinomialReach; ++k) read(k);
    for (int k = first; k < end; ++k) {
      read(k + kBinomialReach);
      for (std::size_t v = 0; v < 3; ++v) {
        const auto slice_at = [&](std::size_t slot) -> const auto& {
          return ring[slot].value[v];
        };
        SmoothRing(k, slice_at, smooth.value[v]);
      }
      pack(smooth, k);
    }
  });
  if (stored[2] > size_[2]) std::copy_n(packed_.begin(), plane, packed_.begin() + plane);
  view_.data = packed_.data();
  view_.row_voxels = stored[0];
  view_.slice_voxels = stored[0] * stored[1];
  for (int a = 0; a < 3; ++a) {
    view_.first[a] = static_cast<float>(first_[a]);
    view_.last[a] = static_cast<float>(stored[a] - 1);
    view_.edge[a] = static_cast<float>(geometry.size[a]) - 0.5F;
  }
}

AcousticVolume::Around AcousticVolume::AroundOf(const Eigen::Array3i& voxel) const {
  Around around;
  const Eigen::Array3i strides(1, view_.row_voxels, view_.slice_voxels);
  for (int a = 0; a < 3; ++a) {
    for (int n = 0; n < Around::kPlaces; ++n) {
      const int at = voxel[a] - first_[a] + kBinomialReach * (n - Around::kPlaces / 2);
      around.at[a][n] = std::clamp(at, 0, size_[a] - 1) * strides[a];
    }
  }
  return around;
}

Eigen::Vector3f AcousticVolume::DifferenceAt(const Around& around,
                                             const Eigen::Array3i& place) const {
  const std::array<int, 3> at = {around.at[0][place[0]], around.at[1][place[1]],
                                 around.at[2][place[2]]};
  const auto code = [&](int voxel) {
    return static_cast<int>(packed_[static_cast<std::size_t>(voxel)] >> 20);
  };
  const int all = at[0] + at[1] + at[2];
  Eigen::Vector3f difference;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    const int others = all - at[a];
    const int change =
        code(others + around.at[a][place[axis] + 1]) - code(others + around.at[a][place[axis] - 1]);
    difference[axis] = static_cast<float>(change) * per_spacing_mm_[axis];
  }
  return difference;
}

Eigen::Vector3d AcousticVolume::NormalAt(const Eigen::Vector3d& index) const {
  const Eigen::Array3i voxel = (index.array() + 0.5).floor().cast<int>();
  const Around around = AroundOf(voxel);
  const Eigen::Array3i middle = Eigen::Array3i::Constant(Around::kPlaces / 2);
  const Eigen::Vector3f here = DifferenceAt(around, middle);
  Eigen::Vector3f sum = here;
  // Around, along the surface, the stairs of labels have other phases; off it the slope is small.
  for (int a = 0; a < 3; ++a) {
    for (const int step : {-2, 2}) {
      Eigen::Array3i beside = middle;
      beside[a] += step;
      const Eigen::Vector3f there = DifferenceAt(around, beside);
      // The far side of a thin layer slopes the other way.
      if (there.dot(here) > 0.0F) sum += there;
    }
  }
  return sum.cast<double>().normalized();
}

}  // namespace acus::ultrasound
