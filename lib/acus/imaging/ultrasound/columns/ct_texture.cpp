#include "acus/imaging/ultrasound/columns/ct_texture.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "acus/base/core/parallel.h"
#include "acus/data/volume/labels.h"
#include "acus/imaging/ultrasound/speckle/binomial_window.h"

namespace acus::ultrasound {
namespace {

/// Hounsfield units above the tissue, and the change of the echo there.
struct Knot {
  double hu;
  double db;
};
constexpr std::array<Knot, 7> kTexture{
    {{-90, 4}, {-30, 2.5}, {-12, 0}, {12, 0}, {35, -6}, {70, -16}, {120, -22}}};

constexpr int kNoTexture = 128;
constexpr double kHuPerCode = 1.5;
constexpr double kBlockMm = 16.0;
/// What is denser or thinner is no soft tissue to compare with.
constexpr int kThinnest = -40;
constexpr int kDensest = 260;
constexpr int kSlicesPerTask = 16;

}  // namespace

double TextureDb(double hu_above_tissue) {
  if (hu_above_tissue <= kTexture.front().hu) return kTexture.front().db;
  for (std::size_t n = 1; n < kTexture.size(); ++n) {
    if (hu_above_tissue > kTexture[n].hu) continue;
    const double share =
        (hu_above_tissue - kTexture[n - 1].hu) / (kTexture[n].hu - kTexture[n - 1].hu);
    return kTexture[n - 1].db + share * (kTexture[n].db - kTexture[n - 1].db);
  }
  return kTexture.back().db;
}

CtTexture::CtTexture(const volume::CtVolume& ct, const volume::LabelMap& labels, int num_threads)
    : code_(ct.voxels.size(), kNoTexture) {
  for (int code = 0; code < 256; ++code) {
    gain_[static_cast<std::size_t>(code)] =
        static_cast<float>(std::pow(10.0, TextureDb((code - kNoTexture) * kHuPerCode) / 20.0));
  }
  FindTextured(labels);
  if (std::all_of(against_.begin(), against_.end(),
                  [](Against a) { return a == Against::kNone; })) {
    return;
  }
  FindMedians(ct, labels);
  FindMeansAround(ct, labels);
  const Eigen::Array3i& size = ct.geometry.size;
  const auto plane = static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
  ParallelFor((size[2] + kSlicesPerTask - 1) / kSlicesPerTask, num_threads, [&](int task) {
    std::array<std::vector<float>, 5> ring;
    std::vector<float> scratch;
    std::vector<float> smooth(plane);
    const auto read = [&](int k) {
      std::vector<float>& slice = ring[RingSlot(k)];
      slice.resize(plane);
      const std::size_t first = ct.geometry.Index(0, 0, std::clamp(k, 0, size[2] - 1));
      std::copy_n(ct.voxels.begin() + static_cast<std::ptrdiff_t>(first), plane, slice.begin());
      SmoothSlice(slice, size[0], size[1], scratch);
    };
    const int first = task * kSlicesPerTask;
    for (int k = first - kBinomialReach; k < first + kBinomialReach; ++k) read(k);
    for (int k = first; k < std::min(size[2], first + kSlicesPerTask); ++k) {
      read(k + kBinomialReach);
      SmoothRing(
          k, [&](std::size_t slot) -> const auto& { return ring[slot]; }, smooth);
      CodeSlice(labels, k, smooth);
    }
  });
}

void CtTexture::FindTextured(const volume::LabelMap& labels) {
  for (const auto& [label, name] : labels.names) {
    if (name == "soft_tissue" || name == "muscle") {
      against_[label] = Against::kAround;
    }
    for (const std::string_view organ :
         {"liver", "kidney", "spleen", "pancreas", "heart", "gland"}) {
      if (name == organ) against_[label] = Against::kOrgan;
    }
  }
}

void CtTexture::FindMedians(const volume::CtVolume& ct, const volume::LabelMap& labels) {
  constexpr int kBins = kDensest - kThinnest;
  std::vector<std::array<std::uint32_t, kBins>> counts(256);
  for (std::size_t n = 0; n < ct.voxels.size(); n += 3) {
    const volume::Label label = labels.voxels[n];
    const int bin = ct.voxels[n] - kThinnest;
    if (against_[label] == Against::kOrgan && bin >= 0 && bin < kBins) {
      ++counts[label][static_cast<std::size_t>(bin)];
    }
  }
  for (std::size_t label = 0; label < 256; ++label) {
    std::uint64_t all = 0;
    for (const std::uint32_t count : counts[label]) all += count;
    std::uint64_t below = 0;
    for (int bin = 0; bin < kBins && 2 * below < all; ++bin) {
      below += counts[label][static_cast<std::size_t>(bin)];
      median_hu_[label] = static_cast<float>(bin + kThinnest);
    }
  }
}

void CtTexture::FindMeansAround(const volume::CtVolume& ct, const volume::LabelMap& labels) {
  const Eigen::Array3i& size = ct.geometry.size;
  block_ = (kBlockMm / ct.geometry.spacing_mm).round().max(1.0).cast<int>();
  blocks_ = (size + block_ - 1) / block_;
  const auto count = static_cast<std::size_t>(blocks_.prod());
  std::vector<double> sum(count, 0.0);
  std::vector<double> number(count, 0.0);
  const auto block_of = [&](int x, int y, int z) {
    return (static_cast<std::size_t>(z) * blocks_[1] + static_cast<std::size_t>(y)) * blocks_[0] +
           static_cast<std::size_t>(x);
  };
  std::size_t n = 0;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i, ++n) {
        const int hu = ct.voxels[n];
        if (against_[labels.voxels[n]] != Against::kAround || hu < kThinnest || hu > kDensest) {
          continue;
        }
        const std::size_t at = block_of(i / block_[0], j / block_[1], k / block_[2]);
        sum[at] += hu;
        number[at] += 1.0;
      }
    }
  }
  mean_hu_.assign(count, 0.0F);
  for (int z = 0; z < blocks_[2]; ++z) {
    for (int y = 0; y < blocks_[1]; ++y) {
      for (int x = 0; x < blocks_[0]; ++x) {
        double s = 0.0;
        double c = 1e-9;
        for (int dz = std::max(0, z - 1); dz <= std::min(blocks_[2] - 1, z + 1); ++dz) {
          for (int dy = std::max(0, y - 1); dy <= std::min(blocks_[1] - 1, y + 1); ++dy) {
            for (int dx = std::max(0, x - 1); dx <= std::min(blocks_[0] - 1, x + 1); ++dx) {
              s += sum[block_of(dx, dy, dz)];
              c += number[block_of(dx, dy, dz)];
            }
          }
        }
        mean_hu_[block_of(x, y, z)] = static_cast<float>(s / c);
      }
    }
  }
}

void CtTexture::MeansOfRow(int j, int k, std::vector<float>& by_block) const {
  struct Between {
    int low;
    int high;
    float share;
  };
  const auto between = [&](int voxel, int axis) {
    const double at = std::clamp((voxel + 0.5) / block_[axis] - 0.5, 0.0, blocks_[axis] - 1.0);
    const int low = static_cast<int>(at);
    return Between{low, std::min(low + 1, blocks_[axis] - 1), static_cast<float>(at - low)};
  };
  const Between y = between(j, 1);
  const Between z = between(k, 2);
  const auto row = [&](int by, int bz) {
    return mean_hu_.data() +
           (static_cast<std::size_t>(bz) * blocks_[1] + static_cast<std::size_t>(by)) * blocks_[0];
  };
  by_block.resize(static_cast<std::size_t>(blocks_[0]));
  for (int x = 0; x < blocks_[0]; ++x) {
    const auto along = [&](int bz) {
      return row(y.low, bz)[x] + y.share * (row(y.high, bz)[x] - row(y.low, bz)[x]);
    };
    by_block[static_cast<std::size_t>(x)] = along(z.low) + z.share * (along(z.high) - along(z.low));
  }
}

void CtTexture::CodeSlice(const volume::LabelMap& labels, int k,
                          const std::vector<float>& smooth_hu) {
  const Eigen::Array3i& size = labels.geometry.size;
  std::vector<float> means;
  const volume::Label* const all = labels.voxels.data();
  for (int j = 0; j < size[1]; ++j) {
    MeansOfRow(j, k, means);
    // Rows next to this one, along j and k.
    std::array<const volume::Label*, 8> beside;
    std::size_t b = 0;
    for (const int step : {-2, -1, 1, 2}) {
      beside[b++] = all + labels.geometry.Index(0, std::clamp(j + step, 0, size[1] - 1), k);
      beside[b++] = all + labels.geometry.Index(0, j, std::clamp(k + step, 0, size[2] - 1));
    }
    const volume::Label* here = all + labels.geometry.Index(0, j, k);
    std::uint8_t* code = code_.data() + labels.geometry.Index(0, j, k);
    const float* hu = smooth_hu.data() + static_cast<std::ptrdiff_t>(j) * size[0];
    const auto other = [&](volume::Label there, volume::Label label) {
      return there != label && against_[there] != Against::kAround;
    };
    for (int i = 2; i + 2 < size[0]; ++i) {
      const volume::Label label = here[i];
      if (against_[label] == Against::kNone) continue;
      bool at_border = other(here[i - 2], label) || other(here[i - 1], label) ||
                       other(here[i + 1], label) || other(here[i + 2], label);
      for (const volume::Label* row : beside) at_border = at_border || other(row[i], label);
      if (at_border) continue;
      float level = median_hu_[label];
      if (against_[label] == Against::kAround) {
        const float at =
            std::clamp((static_cast<float>(i) + 0.5F) / static_cast<float>(block_[0]) - 0.5F, 0.0F,
                       static_cast<float>(blocks_[0] - 1));
        const auto low = static_cast<std::size_t>(at);
        const std::size_t high = std::min(low + 1, means.size() - 1);
        level = means[low] + (at - static_cast<float>(low)) * (means[high] - means[low]);
      }
      const float scaled = (hu[i] - level) / static_cast<float>(kHuPerCode) + kNoTexture + 0.5F;
      code[i] = static_cast<std::uint8_t>(std::min(std::max(scaled, 0.0F), 255.0F));
    }
  }
}

}  // namespace acus::ultrasound
