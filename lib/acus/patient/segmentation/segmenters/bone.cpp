#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "acus/base/core/parallel.h"
#include "acus/patient/segmentation/segmenters/enclosed.h"
#include "acus/patient/segmentation/segmenters/tissues.h"

namespace acus::segmentation {
namespace {

constexpr double kNoiseToSmoothHu = 30.0;
constexpr double kFluidLowHu = -20.0;   ///< A hole between these is the spinal canal or the brain,
constexpr double kFluidHighHu = 70.0;   ///< not marrow: fatty marrow is below, red marrow above.
constexpr double kSmallHoleMm2 = 60.0;  ///< A hole below this is marrow, whatever it holds.
constexpr double kLargeHoleMm2 = 4000.0;
constexpr std::size_t kHistogramStepHu = 4;
constexpr double kMostBloodHu = 480.0;  ///< Arteries just after an injection.
constexpr double kCertainOverContrast =
    1.2;  ///< Noise and narrow vessels are denser in such a scan.
constexpr double kLargestEvenMarrowMm2 = 120.0;
constexpr double kLeastContrastMl = 3.0;
constexpr double kLeastLargestCoreMl = 2.0;  ///< Of a kidney or a great vessel.
constexpr double kSmoothBelowMm = 1.5;       ///< Pixels larger than this are smooth already.
constexpr double kLargeCoreMl = 15.0;
constexpr double kBladderRadiusMm =
    9.0;  ///< A ball of kLargeCoreMl has 15 mm, half a skull's wall 4 mm.
constexpr double kMostRim =
    1.02;  ///< Rim over core of what holds contrast agent; cortex is above 1.3.
constexpr double kSmallCoreMl = 0.5;
constexpr double kMostBloodInSmallCoreHu = 380.0;
constexpr double kLeastMarrowHu = -150.0;
constexpr double kCanalCompactness = 0.5;
constexpr double kFarFromBoneMm = 12.0;
constexpr double kMarginHu = 10.0;  ///< Of the threshold above soft tissue.
constexpr double kCertainGroupMl = 0.01;
constexpr double kReachEnhancedMm = 5.0;
constexpr double kReachPlainMm = 12.0;
constexpr double kAcrossMarrowMm = 30.0;  ///< In a sacrum or a hip, from wall to wall.
constexpr int kLeastWalls = 21;           ///< Of 26 directions; a disc or a joint sees fewer.
constexpr double kForamenMm = 10.0;
constexpr double kCanalHalfZoneMm = 60.0;  ///< Beside the canal that was found.
constexpr double kClosingVoxels = 1.5;     ///< A gap in a cortex is at least that wide.

/// Standard deviation of noise [HU], from differences of neighbours along i in soft tissue.
double NoiseHu(const volume::CtVolume& ct, const Mask& body) {
  std::array<std::size_t, 512> count{};
  std::size_t total = 0;
  for (std::size_t i = 1; i < ct.voxels.size(); i += 3) {
    const int a = ct.voxels[i - 1];
    const int b = ct.voxels[i];
    if (body.voxels[i] == 0 || body.voxels[i - 1] == 0 || a + b < -40 || a + b > 240) continue;
    ++count[static_cast<std::size_t>(std::min(std::abs(a - b), 511))];
    ++total;
  }
  std::size_t sum = 0;
  for (std::size_t d = 0; d < count.size(); ++d) {
    sum += count[d];
    if (2 * sum >= total) return static_cast<double>(d) * 1.4826 / std::sqrt(2.0);
  }
  return 0.0;
}

/// Weights 1-2-1 within the slices.
volume::CtVolume SmoothedInSlices(const volume::CtVolume& ct, int num_threads) {
  volume::CtVolume out = ct;
  const auto& size = ct.geometry.size;
  ParallelFor(size[2], num_threads, [&](int k) {
    for (int j = 1; j + 1 < size[1]; ++j) {
      for (int i = 1; i + 1 < size[0]; ++i) {
        int sum = 0;
        for (int dj = -1; dj <= 1; ++dj) {
          const int row =
              ct.At(i - 1, j + dj, k) + 2 * ct.At(i, j + dj, k) + ct.At(i + 1, j + dj, k);
          sum += dj == 0 ? 2 * row : row;
        }
        out.At(i, j, k) = static_cast<std::int16_t>(sum >= 0 ? sum / 16 : -(-sum / 16));
      }
    }
  });
  return out;
}

/// Values of one component, enough for quantiles.
class Histogram {
 public:
  void Add(int hu) {
    const int bin = std::clamp(hu, 0, 4095) / static_cast<int>(kHistogramStepHu);
    ++count_[static_cast<std::size_t>(bin)];
    ++total_;
  }
  double Quantile(double fraction) const {
    std::size_t sum = 0;
    for (std::size_t bin = 0; bin < count_.size(); ++bin) {
      sum += count_[bin];
      if (static_cast<double>(sum) >= fraction * static_cast<double>(total_)) {
        return static_cast<double>(bin * kHistogramStepHu);
      }
    }
    return 0.0;
  }

 private:
  std::array<std::uint32_t, 1024> count_{};
  std::size_t total_ = 0;
};

/// Carries the numbers of `cores` on into the voxels of `dense` around them, up to `reach_mm` along
/// a path over voxel faces; of two numbers that arrive together the lower wins.
volume::Grid<std::int32_t> Grown(const Components& cores, const Mask& dense, double reach_mm) {
  const volume::Geometry& g = dense.geometry;
  volume::Grid<std::int32_t> number = cores.number;
  std::vector<std::size_t> front;
  for (std::size_t i = 0; i < number.voxels.size(); ++i) {
    if (number.voxels[i] != 0) front.push_back(i);
  }
  const std::size_t row = static_cast<std::size_t>(g.size[0]);
  const std::size_t slice = g.Index(0, 0, 1);
  const double step_mm = g.spacing_mm.minCoeff();
  for (double way_mm = step_mm; way_mm <= reach_mm + 1e-9; way_mm += step_mm) {
    std::vector<std::size_t> next;
    for (const std::size_t at : front) {
      const auto visit = [&](bool exists, std::size_t to) {
        if (!exists || dense.voxels[to] == 0 || number.voxels[to] != 0) return;
        number.voxels[to] = number.voxels[at];
        next.push_back(to);
      };
      const std::size_t i = at % row;
      visit(i > 0, at - 1);
      visit(i + 1 < row, at + 1);
      visit(at % slice >= row, at - row);
      visit(at % slice + row < slice, at + row);
      visit(at >= slice, at - slice);
      visit(at + slice < number.voxels.size(), at + slice);
    }
    front = std::move(next);
  }
  return number;
}

/// Which of the large cores a ball of kBladderRadiusMm fits into: a skull is large, but a shell.
std::vector<std::uint8_t> ThickParts(const Components& cores, const Mask& dense, int num_threads) {
  std::vector<std::uint8_t> is_thick(cores.num_voxels.size(), 0);
  const double ml = dense.geometry.voxel_volume_mm3() / 1000.0;
  std::vector<std::uint8_t> is_large(cores.num_voxels.size(), 0);
  for (std::size_t n = 1; n < is_large.size(); ++n) {
    is_large[n] = static_cast<double>(cores.num_voxels[n]) * ml > kLargeCoreMl ? 1 : 0;
  }
  if (std::ranges::count(is_large, 1) == 0) return is_thick;
  const Mask inner = Eroded(dense, kBladderRadiusMm, num_threads);
  for (std::size_t i = 0; i < inner.voxels.size(); ++i) {
    const auto n = static_cast<std::size_t>(cores.number.voxels[i]);
    if (inner.voxels[i] != 0 && is_large[n] != 0) is_thick[n] = 1;
  }
  return is_thick;
}

/// The thick, even parts of `dense`: organs, vessels and bowel that hold contrast agent. Their rim
/// is mixed with what surrounds them and less dense than the core; the rim of spongy bone is
/// cortex.
Mask ContrastIn(const volume::CtVolume& ct, const Mask& dense, const TissueOptions& options,
                int num_threads) {
  const Components cores =
      ConnectedComponents(Eroded(dense, options.contrast_core_mm, num_threads));
  const double reach_mm = options.contrast_core_mm + 2.0 * ct.geometry.spacing_mm.minCoeff();
  const volume::Grid<std::int32_t> grown = Grown(cores, dense, reach_mm);
  std::vector<Histogram> core(cores.num_voxels.size());
  std::vector<Histogram> rim(cores.num_voxels.size());
  for (std::size_t i = 0; i < ct.voxels.size(); ++i) {
    const auto n = static_cast<std::size_t>(grown.voxels[i]);
    if (n != 0) (cores.number.voxels[i] != 0 ? core : rim)[n].Add(ct.voxels[i]);
  }
  const double ml = ct.geometry.voxel_volume_mm3() / 1000.0;
  std::vector<std::uint8_t> is_contrast(cores.num_voxels.size(), 0);
  const std::vector<std::uint8_t> is_thick = ThickParts(cores, dense, num_threads);
  double contrast_ml = 0.0, largest_ml = 0.0;
  for (std::size_t n = 1; n < is_contrast.size(); ++n) {
    const double median = core[n].Quantile(0.5);
    const double high = core[n].Quantile(0.95);
    const double spread = (high - median) / median;
    const double size_ml = static_cast<double>(cores.num_voxels[n]) * ml;
    const double most_hu = size_ml > kSmallCoreMl ? kMostBloodHu : kMostBloodInSmallCoreHu;
    const bool is_blood = spread < options.contrast_max_spread && high < most_hu &&
                          rim[n].Quantile(0.6) < kMostRim * median;
    // A bladder full of contrast agent is as dense as bone, but no bone is so thick and even.
    const bool is_bladder = spread < 0.5 * options.contrast_max_spread && size_ml > kLargeCoreMl &&
                            is_thick[n] != 0 && rim[n].Quantile(0.6) < kMostRim * median;
    is_contrast[n] = is_blood || is_bladder ? 1 : 0;
    if (is_contrast[n] == 0) continue;
    contrast_ml += size_ml;
    largest_ml = std::max(largest_ml, size_ml);
  }
  Mask contrast(ct.geometry);
  // Contrast agent fills a kidney or a great vessel or is nowhere; many crumbs are spongy bone.
  if (contrast_ml < kLeastContrastMl || largest_ml < kLeastLargestCoreMl) return contrast;
  for (std::size_t i = 0; i < contrast.voxels.size(); ++i) {
    contrast.voxels[i] = is_contrast[static_cast<std::size_t>(grown.voxels[i])];
  }
  return contrast;
}

/// The least HU of bone in this scan: above nearly all of what lies far from certain bone, which
/// depends on how much contrast agent there is in blood and organs.
double ThresholdHu(const volume::CtVolume& ct, const Mask& body, const Mask& certain,
                   const TissueOptions& options, int num_threads) {
  const Mask near = Dilated(certain, kFarFromBoneMm, num_threads);
  Histogram soft;
  for (std::size_t i = 0; i < ct.voxels.size(); ++i) {
    if (body.voxels[i] != 0 && near.voxels[i] == 0 && ct.voxels[i] > 0) soft.Add(ct.voxels[i]);
  }
  return std::clamp(soft.Quantile(0.995) + kMarginHu, options.bone_lowest_hu,
                    options.bone_threshold_hu);
}

/// Where the values leave no doubt: above certain_hu, in groups of some voxels.
Mask CertainBone(const volume::CtVolume& ct, const Mask& body, const Mask& contrast,
                 double certain_hu) {
  Mask certain(ct.geometry);
  for (std::size_t i = 0; i < certain.voxels.size(); ++i) {
    certain.voxels[i] =
        body.voxels[i] != 0 && contrast.voxels[i] == 0 && ct.voxels[i] > certain_hu ? 1 : 0;
  }
  const Components groups = ConnectedComponents(certain);
  const double ml = ct.geometry.voxel_volume_mm3() / 1000.0;
  return Kept(groups, [&](std::int32_t n) {
    return static_cast<double>(groups.num_voxels[static_cast<std::size_t>(n)]) * ml >=
           kCertainGroupMl;
  });
}

/// Components that are large enough.
Mask LargeParts(const Mask& mask, double min_ml) {
  const Components parts = ConnectedComponents(mask);
  const double ml = mask.geometry.voxel_volume_mm3() / 1000.0;
  return Kept(parts, [&](std::int32_t n) {
    return static_cast<double>(parts.num_voxels[static_cast<std::size_t>(n)]) * ml >= min_ml;
  });
}

/// Area over the area of a circle of the same circumference: 1 for a disc, small for a strip.
double Compactness(const SliceRegion& region, const volume::Geometry& g, int axis) {
  const std::array<std::size_t, 3> stride = {1, static_cast<std::size_t>(g.size[0]),
                                             g.Index(0, 0, 1)};
  const int u = axis == 0 ? 1 : 0;
  const int v = axis == 2 ? 1 : 2;
  const std::vector<std::size_t>& in = region.voxels;  // Sorted by the caller.
  double edge_mm = 0.0;
  for (const std::size_t at : in) {
    for (const int along : {u, v}) {
      const std::size_t step = stride[static_cast<std::size_t>(along)];
      const double side_mm = g.spacing_mm[along == u ? v : u];
      if (!std::ranges::binary_search(in, at + step)) edge_mm += side_mm;
      if (!std::ranges::binary_search(in, at - step)) edge_mm += side_mm;
    }
  }
  const double around_mm = edge_mm * M_PI / 4.0;  // A staircase is that much longer than its curve.
  const double area_mm2 = static_cast<double>(in.size()) * g.spacing_mm[u] * g.spacing_mm[v];
  return 4.0 * M_PI * area_mm2 / (around_mm * around_mm);
}

/// Whether a hole within a ring of bone is marrow, and not the spinal canal, the brain or a disc.
bool IsMarrow(const volume::CtVolume& ct, const SliceRegion& hole, int axis, bool is_axial) {
  const double pixel_mm2 = ct.geometry.voxel_volume_mm3() / ct.geometry.spacing_mm[axis];
  const double area_mm2 = static_cast<double>(hole.voxels.size()) * pixel_mm2;
  if (hole.touches_border || area_mm2 > kLargeHoleMm2) return false;
  double sum = 0.0;
  for (const std::size_t at : hole.voxels) sum += ct.voxels[at];
  const double mean = sum / static_cast<double>(hole.voxels.size());
  if (mean < kLeastMarrowHu) return false;
  if (area_mm2 < kSmallHoleMm2) return true;
  // In other planes a disc is enclosed as well, between the end plates of its neighbours.
  if (!is_axial) return false;
  if (mean > kFluidHighHu || mean < kFluidLowHu) return true;
  SliceRegion sorted = hole;
  std::ranges::sort(sorted.voxels);
  return Compactness(sorted, ct.geometry, axis) < kCanalCompactness;
}

/// Adds what the bone encloses in a slice, along all three axes, but nothing that reaches into
/// `open`. Returns the holes of axial slices that may be the canal or the brain.
Mask FillMarrow(const volume::CtVolume& ct, const BoneFound& found, const Mask& open, Mask& bone,
                int num_threads) {
  Mask refused(ct.geometry);
  Mask filled = found.shell;
  for (std::size_t i = 0; i < filled.voxels.size(); ++i) {
    if (open.voxels[i] != 0) filled.voxels[i] = 0;
  }
  const int axial = AxialAxis(ct.geometry);
  for (const int axis : {axial, (axial + 1) % 3, (axial + 2) % 3}) {
    FillInSlices(filled, axis, num_threads, [&](const SliceRegion& hole) {
      if (std::ranges::any_of(hole.voxels, [&](std::size_t at) { return open.voxels[at] != 0; })) {
        return false;
      }
      const bool is_marrow = IsMarrow(ct, hole, axis, axis == axial);
      if (axis == axial && !is_marrow && !hole.touches_border) {
        for (const std::size_t at : hole.voxels) refused.voxels[at] = 1;
      }
      return is_marrow;
    });
  }
  for (std::size_t i = 0; i < bone.voxels.size(); ++i) {
    if (filled.voxels[i] != 0 && ct.voxels[i] > kLeastMarrowHu) bone.voxels[i] = 1;
  }
  return refused;
}

/// The refused holes that may be a canal that was not found: in slices without `open`, and no
/// farther beside it than a spine bends; all of them without a spine.
Mask PossibleCanal(const Mask& refused, const Mask& open) {
  const volume::Geometry& g = open.geometry;
  const auto along = static_cast<std::size_t>(AxialAxis(g));
  std::vector<std::uint8_t> has_canal(static_cast<std::size_t>(g.size.maxCoeff()), 0);
  double sum_mm = 0.0, count = 0.0;
  const auto for_each = [&](const Mask& mask, const auto& visit) {
    for (int k = 0; k < g.size[2]; ++k) {
      for (int j = 0; j < g.size[1]; ++j) {
        for (int i = 0; i < g.size[0]; ++i) {
          if (mask.At(i, j, k) == 0) continue;
          const std::array at = {i, j, k};
          visit(i, j, k, static_cast<std::size_t>(at[along]),
                (g.ct_from_index() * Eigen::Vector3d(i, j, k)).x());
        }
      }
    }
  };
  for_each(open, [&](int, int, int, std::size_t slice, double x_mm) {
    has_canal[slice] = 1;
    sum_mm += x_mm;
    ++count;
  });
  Mask possible(g);
  for_each(refused, [&](int i, int j, int k, std::size_t slice, double x_mm) {
    const bool is_beside = count > 0.0 && std::abs(x_mm - sum_mm / count) > kCanalHalfZoneMm;
    possible.At(i, j, k) = has_canal[slice] == 0 && !is_beside ? 1 : 0;
  });
  return possible;
}

/// Adds what has bone around it, seen from inside, though no slice shows a closed cortex; but
/// neither a possible canal nor what lies beside `open`: foramina have bone all around.
void FillEnclosed(const volume::CtVolume& ct, const BoneFound& found, const Mask& possible_canal,
                  const Mask& open, Mask& bone, int num_threads) {
  Mask walls = found.shell;
  for (std::size_t i = 0; i < walls.voxels.size(); ++i) walls.voxels[i] |= bone.voxels[i];
  const Mask enclosed = Enclosed(walls, kAcrossMarrowMm, kLeastWalls, num_threads);
  const Mask beside = Dilated(open, kForamenMm, num_threads);
  for (std::size_t i = 0; i < bone.voxels.size(); ++i) {
    const bool is_marrow = enclosed.voxels[i] != 0 && ct.voxels[i] > kLeastMarrowHu;
    if (is_marrow && possible_canal.voxels[i] == 0 && beside.voxels[i] == 0) bone.voxels[i] = 1;
  }
}

}  // namespace

BoneFound FindDenseBone(const volume::CtVolume& original, const Mask& body,
                        const TissueOptions& options, int num_threads) {
  BoneFound found;
  found.noise_hu = NoiseHu(original, body);
  const bool noisy = found.noise_hu > kNoiseToSmoothHu;
  const double pixel_mm = original.geometry.spacing_mm.minCoeff();
  const volume::CtVolume smoothed =
      pixel_mm < kSmoothBelowMm ? SmoothedInSlices(original, num_threads) : original;
  const volume::CtVolume& ct = noisy ? smoothed : original;
  const auto above = [&](const volume::CtVolume& values, double hu) {
    Mask mask(values.geometry);
    for (std::size_t i = 0; i < mask.voxels.size(); ++i) {
      mask.voxels[i] = body.voxels[i] != 0 && values.voxels[i] > hu ? 1 : 0;
    }
    return mask;
  };
  // Noise would break an organ that is just above the threshold into crumbs.
  found.contrast =
      ContrastIn(smoothed, above(smoothed, options.bone_threshold_hu), options, num_threads);
  Mask certain = CertainBone(ct, body, found.contrast, options.bone_certain_hu);
  found.threshold_hu = ThresholdHu(ct, body, certain, options, num_threads);
  found.enhanced = found.threshold_hu > 0.5 * (options.bone_lowest_hu + options.bone_threshold_hu);
  if (found.enhanced) {
    certain = CertainBone(ct, body, found.contrast, kCertainOverContrast * options.bone_certain_hu);
  }
  // Blood lies beside bone, so in an enhanced scan only what is close to certain bone is taken.
  const Mask near =
      Dilated(certain, found.enhanced ? kReachEnhancedMm : kReachPlainMm, num_threads);
  Mask bone = above(ct, found.threshold_hu);
  for (std::size_t i = 0; i < bone.voxels.size(); ++i) {
    if (near.voxels[i] == 0 || found.contrast.voxels[i] != 0) bone.voxels[i] = 0;
  }
  found.dense = LargeParts(bone, options.bone_min_part_ml);
  const double in_plane_mm =
      std::min({original.geometry.spacing_mm[0], original.geometry.spacing_mm[1]});
  found.shell = Closed(found.dense, std::max(options.bone_closing_mm, kClosingVoxels * in_plane_mm),
                       num_threads);
  return found;
}

Mask BoneWithMarrow(const volume::CtVolume& ct, const Mask& body, const BoneFound& found,
                    const Mask& open, const TissueOptions& options, int num_threads) {
  Mask bone = found.dense;
  const Mask refused = FillMarrow(ct, found, open, bone, num_threads);
  FillEnclosed(ct, found, PossibleCanal(refused, open), open, bone, num_threads);
  for (std::size_t i = 0; i < bone.voxels.size(); ++i) {
    bone.voxels[i] &= body.voxels[i];
    if (found.contrast.voxels[i] != 0 || open.voxels[i] != 0) bone.voxels[i] = 0;
  }
  // Even marrow that was taken for contrast agent is bone all around.
  const int axial = AxialAxis(ct.geometry);
  const double pixel_mm2 = ct.geometry.voxel_volume_mm3() / ct.geometry.spacing_mm[axial];
  FillInSlices(bone, axial, num_threads, [&](const SliceRegion& hole) {
    const double area_mm2 = static_cast<double>(hole.voxels.size()) * pixel_mm2;
    return !hole.touches_border && area_mm2 < kLargestEvenMarrowMm2 &&
           std::ranges::all_of(hole.voxels, [&](std::size_t at) {
             return open.voxels[at] == 0 &&
                    (ct.voxels[at] > options.bone_lowest_hu || found.contrast.voxels[at] != 0);
           });
  });
  return bone;
}

}  // namespace acus::segmentation
