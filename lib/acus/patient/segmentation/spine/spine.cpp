#include "acus/patient/segmentation/spine/spine.h"

#include <algorithm>

#include "acus/base/core/text_table.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/spine/spine_parts.h"
#include "acus/patient/segmentation/voxels/lps_axes.h"

namespace acus::segmentation {
namespace {

constexpr double kMostObliqueDeg = 30.0;
constexpr double kBesideMm = 3.0;
constexpr double kBelowThresholdHu = 45.0;
constexpr double kWideClosingMm = 2.0;
constexpr double kNoMuscleMm = 2.5;  ///< No muscle lies so close to the canal.

/// Bone with what is somewhat less dense beside it, its gaps closed: the ring of an arch is whole
/// here where thick slices or a high threshold have opened it.
Mask WideShell(const volume::CtVolume& ct, const BoneFound& bone, int num_threads) {
  Mask wide = Dilated(bone.dense, kBesideMm, num_threads);
  for (std::size_t i = 0; i < wide.voxels.size(); ++i) {
    if (ct.voxels[i] < bone.threshold_hu - kBelowThresholdHu) wide.voxels[i] = 0;
    wide.voxels[i] |= bone.dense.voxels[i];
  }
  return Closed(wide, std::max(kWideClosingMm, 1.5 * ct.geometry.spacing_mm.minCoeff()),
                num_threads);
}

/// In both shells; in each slice the chain takes the hole that fits it best.
std::vector<CanalHole> HolesOf(const volume::CtVolume& ct, const Mask& shell, const Mask& wide,
                               int num_threads) {
  std::vector<CanalHole> holes = FindCanalHoles(ct, shell, num_threads);
  const auto more = FindCanalHoles(ct, wide, num_threads);
  holes.insert(holes.end(), more.begin(), more.end());
  std::ranges::stable_sort(holes, {}, &CanalHole::k);
  return holes;
}

}  // namespace

std::optional<Spine> FindSpine(const volume::CtVolume& original, const Mask& body,
                               const BoneFound& bone, const TissueOptions& options,
                               int num_threads) {
  const volume::Geometry& g = original.geometry;
  if (ObliquityDeg(g) > kMostObliqueDeg) return std::nullopt;
  const AxisOrder order = LpsOrder(g);
  const auto turned = [&](const auto& grid) { return Turned(grid, g, order, true); };
  const auto back = [&](const auto& grid) { return Turned(grid, g, order, false); };
  const volume::CtVolume ct = turned(original);
  const auto chain = CanalChain(
      HolesOf(ct, turned(bone.shell), turned(WideShell(original, bone, num_threads)), num_threads),
      ct.geometry);
  if (chain.empty()) return std::nullopt;
  const CanalTube tube = FitCanalTube(ct, chain, bone.threshold_hu);
  const Mask canal = CanalMask(tube, ct, bone.threshold_hu);
  const Mask dense = turned(bone.dense);
  const SpineView view{ct, dense, tube, canal};
  Spine spine;
  spine.canal = back(canal);
  spine.disc = back(FindDiscs(view, options.fat_upper_hu));
  Mask ligament = FindSpineLigaments(view, options.fat_upper_hu);
  const Mask lining = CanalLining(tube, ct, dense, canal, options.fat_upper_hu);
  for (std::size_t n = 0; n < ligament.voxels.size(); ++n) ligament.voxels[n] |= lining.voxels[n];
  Mask muscle = FindBackMuscles(view, turned(body), options.fat_upper_hu);
  const Mask near =
      Dilated(canal, std::max(kNoMuscleMm, 1.01 * ct.geometry.spacing_mm.minCoeff()), num_threads);
  for (std::size_t n = 0; n < muscle.voxels.size(); ++n) {
    const bool is_flavum = muscle.voxels[n] != 0 && near.voxels[n] != 0 && canal.voxels[n] == 0;
    if (!is_flavum) continue;
    muscle.voxels[n] = 0;
    ligament.voxels[n] = 1;
  }
  spine.ligament = back(ligament);
  spine.muscle = back(muscle);
  return spine;
}

std::string SpineSentence(const volume::LabelMap& labels) {
  const auto count = std::ranges::count(labels.voxels, volume::LabelOf("spinal_canal"));
  if (count == 0) {
    return "No spine found in the CT: no spinal canal, discs, ligaments or back muscles are "
           "labelled.\n";
  }
  const double ml = static_cast<double>(count) * labels.geometry.voxel_volume_mm3() / 1000.0;
  return Message("Spine found: ", FixedText(ml, 1), " ml of spinal canal.\n");
}

}  // namespace acus::segmentation
