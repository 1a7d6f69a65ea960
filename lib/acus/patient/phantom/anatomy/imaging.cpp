#include "acus/patient/phantom/anatomy/imaging.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/parallel.h"
#include "acus/base/core/random.h"
#include "acus/data/volume/labels.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;
using volume::Geometry;
using volume::Grid;

constexpr int kTile = 16;  ///< Voxels; parts are looked up once for each tile of a slice.

/// Calls visit(i, j, parts near) for each voxel of slice k.
template <typename Visit>
void ForSlice(const Anatomy& anatomy, const Geometry& g, int k, const Visit& visit) {
  const Eigen::Affine3d ct_from_index = g.ct_from_index();
  for (int j0 = 0; j0 < g.size[1]; j0 += kTile) {
    for (int i0 = 0; i0 < g.size[0]; i0 += kTile) {
      const Box tile(Vector3d(i0 - 0.5, j0 - 0.5, k - 0.5),
                     Vector3d(i0 + kTile - 0.5, j0 + kTile - 0.5, k + 0.5));
      const Anatomy::Nearby parts = anatomy.PartsIn(tile.transformed(ct_from_index));
      for (int j = j0; j < std::min(j0 + kTile, g.size[1]); ++j) {
        for (int i = i0; i < std::min(i0 + kTile, g.size[0]); ++i) visit(i, j, parts);
      }
    }
  }
}

/// Runs body(k) for all slices, on threads, with progress.
template <typename Body>
void ForSlices(int count, std::string_view task, const RunContext& context, const Body& body) {
  constexpr int kChunk = 8;
  for (int k0 = 0; k0 < count; k0 += kChunk) {
    context.Checkpoint(task, static_cast<double>(k0) / count);
    ParallelFor(std::min(kChunk, count - k0), context.num_threads, [&](int i) { body(k0 + i); });
  }
}

Grid<Material> RenderMaterials(const Anatomy& anatomy, const Geometry& g,
                               const RunContext& context) {
  Grid<Material> materials(g);
  const Eigen::Affine3d ct_from_index = g.ct_from_index();
  ForSlices(g.size[2], "anatomy", context, [&](int k) {
    ForSlice(anatomy, g, k, [&](int i, int j, const Anatomy::Nearby& parts) {
      materials.At(i, j, k) = anatomy.MaterialAt(ct_from_index * Vector3d(i, j, k), parts);
    });
  });
  return materials;
}

/// True if all voxels around (i, j, k) are of one material.
bool IsPure(const Grid<Material>& materials, int i, int j, int k) {
  const Geometry& g = materials.geometry;
  const Material here = materials.At(i, j, k);
  for (int c = std::max(k - 1, 0); c <= std::min(k + 1, g.size[2] - 1); ++c) {
    for (int b = std::max(j - 1, 0); b <= std::min(j + 1, g.size[1] - 1); ++b) {
      for (int a = std::max(i - 1, 0); a <= std::min(i + 1, g.size[0] - 1); ++a) {
        if (materials.At(a, b, c) != here) return false;
      }
    }
  }
  return true;
}

/// Mean HU over n^3 points spread evenly in the voxel.
double MixedHu(const Anatomy& anatomy, const ScannerSettings& settings,
               const Eigen::Affine3d& ct_from_index, const Vector3d& index,
               const Anatomy::Nearby& parts) {
  const int n = settings.supersampling;
  double sum = 0.0;
  for (int c = 0; c < n; ++c) {
    for (int b = 0; b < n; ++b) {
      for (int a = 0; a < n; ++a) {
        const Vector3d offset = Vector3d(a + 0.5, b + 0.5, c + 0.5) / n - Vector3d::Constant(0.5);
        const Material m = anatomy.MaterialAt(ct_from_index * (index + offset), parts);
        sum += settings.hu[static_cast<std::size_t>(m)];
      }
    }
  }
  return sum / (n * n * n);
}

/// Weights 0..r of a sampled Gaussian that sum to one over -r..r.
std::vector<float> GaussianWeights(double sigma_voxels) {
  const int reach = static_cast<int>(std::ceil(3.0 * sigma_voxels));
  std::vector<double> w;
  double sum = 0.0;
  for (int r = 0; r <= reach; ++r) {
    w.push_back(sigma_voxels > 0.0 ? std::exp(-0.5 * r * r / (sigma_voxels * sigma_voxels)) : 1.0);
    sum += r == 0 ? w.back() : 2.0 * w.back();
  }
  std::vector<float> weights;
  for (const double value : w) weights.push_back(static_cast<float>(value / sum));
  return weights;
}

/// Smooths `count` values that lie `stride` apart; beyond the ends the last value continues.
void SmoothLine(float* values, std::size_t stride, int count, const std::vector<float>& weights,
                std::vector<float>& line) {
  line.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) line[i] = values[i * stride];
  for (int i = 0; i < count; ++i) {
    float sum = weights[0] * line[i];
    for (int r = 1; r < static_cast<int>(weights.size()); ++r) {
      sum += weights[r] * (line[std::max(i - r, 0)] + line[std::min(i + r, count - 1)]);
    }
    values[i * stride] = sum;
  }
}

void Blur(Grid<float>& hu, double sigma_mm, const RunContext& context) {
  const Geometry& g = hu.geometry;
  const auto row = static_cast<std::size_t>(g.size[0]);
  std::array<std::vector<float>, 3> weights;
  for (int axis = 0; axis < 3; ++axis)
    weights[axis] = GaussianWeights(sigma_mm / g.spacing_mm[axis]);
  ForSlices(g.size[2], "blur", context, [&](int k) {
    std::vector<float> line;
    for (int j = 0; j < g.size[1]; ++j)
      SmoothLine(&hu.voxels[g.Index(0, j, k)], 1, g.size[0], weights[0], line);
    for (int i = 0; i < g.size[0]; ++i)
      SmoothLine(&hu.voxels[g.Index(i, 0, k)], row, g.size[1], weights[1], line);
  });
  ForSlices(g.size[1], "blur", context, [&](int j) {
    std::vector<float> line;
    const std::size_t slice = row * static_cast<std::size_t>(g.size[1]);
    for (int i = 0; i < g.size[0]; ++i)
      SmoothLine(&hu.voxels[g.Index(i, j, 0)], slice, g.size[2], weights[2], line);
  });
}

/// Noise of one slice, standard deviation 1, smoothed by [1 2 1]/4 along both axes: reconstructed
/// CT noise is grainy, not white.
std::vector<float> SliceNoise(const Geometry& g, std::uint64_t seed, int k) {
  const std::size_t width = static_cast<std::size_t>(g.size[0]) + 2;
  const std::size_t height = static_cast<std::size_t>(g.size[1]) + 2;
  RandomStream random(seed, "voxel noise of slice", static_cast<std::uint64_t>(k));
  std::vector<float> white(width * height);
  for (float& value : white) value = static_cast<float>(random.Normal());
  // [1 2 1] along both axes has (1 + 4 + 1)^2 as sum of squares.
  constexpr float kScale = 1.0F / 6.0F;
  std::vector<float> noise;
  noise.reserve(g.num_voxels() / static_cast<std::size_t>(g.size[2]));
  const auto across = [&](std::size_t at) {
    return white[at - 1] + 2.0F * white[at] + white[at + 1];
  };
  for (std::size_t j = 1; j + 1 < height; ++j) {
    for (std::size_t i = 1; i + 1 < width; ++i) {
      const std::size_t at = j * width + i;
      noise.push_back(kScale * (across(at - width) + 2.0F * across(at) + across(at + width)));
    }
  }
  return noise;
}

/// Partial volume: HU of each voxel before blur and noise.
Grid<float> MeanHu(const Anatomy& anatomy, const Grid<Material>& materials,
                   const ScannerSettings& settings, const RunContext& context) {
  Grid<float> hu(materials.geometry);
  const Eigen::Affine3d ct_from_index = hu.geometry.ct_from_index();
  ForSlices(hu.geometry.size[2], "CT", context, [&](int k) {
    ForSlice(anatomy, hu.geometry, k, [&](int i, int j, const Anatomy::Nearby& parts) {
      const double value =
          IsPure(materials, i, j, k)
              ? settings.hu[static_cast<std::size_t>(materials.At(i, j, k))]
              : MixedHu(anatomy, settings, ct_from_index, Vector3d(i, j, k), parts);
      hu.At(i, j, k) = static_cast<float>(value);
    });
  });
  return hu;
}

volume::CtVolume WithNoise(const Grid<float>& hu, double noise_sd_hu, const RunContext& context) {
  volume::CtVolume ct(hu.geometry);
  const auto sd = static_cast<float>(noise_sd_hu);
  ForSlices(hu.geometry.size[2], "noise", context, [&](int k) {
    const std::vector<float> noise = SliceNoise(hu.geometry, context.seed, k);
    const std::size_t first = hu.geometry.Index(0, 0, k);
    for (std::size_t n = 0; n < noise.size(); ++n) {
      const float value = std::clamp(hu.voxels[first + n] + sd * noise[n], -1024.0F, 3071.0F);
      ct.voxels[first + n] = static_cast<std::int16_t>(std::lround(value));
    }
  });
  return ct;
}

volume::LabelMap ToLabels(const Grid<Material>& materials) {
  volume::LabelMap labels(materials.geometry);
  std::ranges::transform(materials.voxels, labels.voxels.begin(),
                         [](Material m) { return LabelOf(m); });
  std::array<bool, 256> present{};
  for (const volume::Label label : labels.voxels) present[label] = true;
  for (const volume::StandardLabel& known : volume::StandardLabels()) {
    if (present[known.label]) labels.names[known.label] = known.name;
  }
  return labels;
}

}  // namespace

Scan RenderScan(const Anatomy& anatomy, const Geometry& geometry, const ScannerSettings& settings,
                const RunContext& context) {
  const Grid<Material> materials = RenderMaterials(anatomy, geometry, context);
  Grid<float> hu = MeanHu(anatomy, materials, settings, context);
  if (settings.psf_sigma_mm > 0.0) Blur(hu, settings.psf_sigma_mm, context);
  return {WithNoise(hu, settings.noise_sd_hu, context), ToLabels(materials)};
}

}  // namespace acus::phantom
