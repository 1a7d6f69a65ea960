#include "acus/patient/segmentation/segmenters/tissues.h"

#include <algorithm>

#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/spine/spine.h"
#include "acus/patient/segmentation/spine/vertebrae.h"
#include "acus/patient/segmentation/voxels/crop.h"

namespace acus::segmentation {
namespace {

constexpr std::size_t kSoftTissueStep = 11;  ///< Enough voxels for a median.

/// The outermost layer of the body, by what lies beyond it.
struct OuterLayer {
  Mask skin;  ///< Air. Where the border of the volume cuts the body there is no layer.
  Mask cut;   ///< What the scanner did not see.
};

Mask LayerOf(const Mask& body, const Mask& inner) {
  Mask layer(body.geometry);
  for (std::size_t i = 0; i < layer.voxels.size(); ++i) {
    layer.voxels[i] = body.voxels[i] != 0 && inner.voxels[i] == 0 ? 1 : 0;
  }
  return layer;
}

OuterLayer OuterLayerOf(const Mask& body, const Mask& unseen, double thickness_mm,
                        int num_threads) {
  // At least one voxel, so that a coarse CT has a skin too.
  const double depth_mm = std::max(thickness_mm, 1.01 * body.geometry.spacing_mm.minCoeff());
  OuterLayer out{LayerOf(body, Eroded(body, depth_mm, num_threads)), Mask(body.geometry)};
  if (Count(unseen) == 0) return out;
  Mask not_air = unseen;
  for (std::size_t i = 0; i < not_air.voxels.size(); ++i) not_air.voxels[i] |= body.voxels[i];
  const Mask to_air = LayerOf(body, Eroded(not_air, depth_mm, num_threads));
  for (std::size_t i = 0; i < out.cut.voxels.size(); ++i) {
    out.cut.voxels[i] = out.skin.voxels[i] != 0 && to_air.voxels[i] == 0 ? 1 : 0;
  }
  out.skin = to_air;
  return out;
}

volume::Label LabelAt(std::size_t i, const volume::CtVolume& ct, const Mask& bone,
                      const AirSpaces& air, const OuterLayer& layer, const TissueOptions& options) {
  static const volume::Label kSkin = volume::LabelOf("skin");
  static const volume::Label kCut = volume::LabelOf("cut");
  static const volume::Label kFat = volume::LabelOf("fat");
  static const volume::Label kSoft = volume::LabelOf("soft_tissue");
  static const volume::Label kBone = volume::LabelOf("bone");
  static const volume::Label kLung = volume::LabelOf("lung");
  static const volume::Label kGas = volume::LabelOf("gas");
  if (bone.voxels[i] != 0) return kBone;
  if (air.lung.voxels[i] != 0) return kLung;
  // Air within the outermost layer is the rounded edge of the body, not a cavity.
  if (layer.skin.voxels[i] != 0) return kSkin;
  if (layer.cut.voxels[i] != 0) return kCut;
  if (air.gas.voxels[i] != 0) return kGas;
  return ct.voxels[i] < options.fat_upper_hu ? kFat : kSoft;
}

/// What stays open when marrow is filled.
Mask OpenIn(const std::optional<Spine>& spine, const volume::Geometry& geometry) {
  Mask open(geometry);
  if (!spine) return open;
  for (std::size_t i = 0; i < open.voxels.size(); ++i) {
    open.voxels[i] = spine->canal.voxels[i] | spine->disc.voxels[i];
  }
  return open;
}

/// The label where a spine was found: its parts take the place of fat and soft tissue.
volume::Label WithSpine(std::size_t i, const Spine& spine, volume::Label label) {
  static const volume::Label kFat = volume::LabelOf("fat");
  static const volume::Label kSoft = volume::LabelOf("soft_tissue");
  static const volume::Label kCanal = volume::LabelOf("spinal_canal");
  static const volume::Label kDisc = volume::LabelOf("disc");
  static const volume::Label kLigament = volume::LabelOf("ligament");
  static const volume::Label kMuscle = volume::LabelOf("muscle");
  if (label != kFat && label != kSoft) return label;
  if (spine.canal.voxels[i] != 0) return kCanal;
  if (spine.disc.voxels[i] != 0) return kDisc;
  if (spine.ligament.voxels[i] != 0) return kLigament;
  return label == kSoft && spine.muscle.voxels[i] != 0 ? kMuscle : label;
}

ScanParameters ScanOf(const volume::CtVolume& ct, const Mask& body, const BoneFound& bone,
                      const TissueOptions& options) {
  ScanParameters scan;
  scan.noise_hu = bone.noise_hu;
  scan.bone_threshold_hu = bone.threshold_hu;
  scan.enhanced = bone.enhanced;
  scan.contrast_ml =
      static_cast<double>(Count(bone.contrast)) * ct.geometry.voxel_volume_mm3() / 1000.0;
  std::vector<std::int16_t> soft;
  for (std::size_t i = 0; i < ct.voxels.size(); i += kSoftTissueStep) {
    const bool is_soft = body.voxels[i] != 0 && ct.voxels[i] >= options.fat_upper_hu &&
                         ct.voxels[i] < bone.threshold_hu;
    if (is_soft) soft.push_back(ct.voxels[i]);
  }
  scan.soft_tissue_hu = MedianHu(soft);
  return scan;
}

}  // namespace

int MedianHu(std::vector<std::int16_t>& values) {
  if (values.empty()) return -1024;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

TissuesFound FindTissues(const volume::CtVolume& original, const TissueOptions& options,
                         const RunContext& context) {
  const int num_threads = context.num_threads;
  context.Checkpoint("finding the body", 0.0);
  const ScanField field = FindScanField(original);
  const auto repaired =
      WithoutDensePadding(original, field, options.body_threshold_hu, num_threads);
  const volume::CtVolume& whole = repaired ? *repaired : original;
  const Mask unseen = UnseenBy(field, whole);
  const Mask whole_body = FindBody(whole, unseen, options, num_threads);
  // All that follows is inside the body: a third to a half of the volume is saved.
  const Box box = BoundsOf(whole_body);
  const volume::CtVolume ct = Cropped(whole, box);
  const Mask body = Cropped(whole_body, box);
  context.Checkpoint("finding lungs and gas", 0.3);
  const AirSpaces air = FindAirSpaces(ct, body, options, num_threads);
  context.Checkpoint("finding bone", 0.5);
  const BoneFound dense = FindDenseBone(ct, body, options, num_threads);
  context.Checkpoint("finding the spine", 0.6);
  const std::optional<Spine> spine = FindSpine(ct, body, dense, options, num_threads);
  const Mask bone = TrimmedToEdge(
      ct, BoneWithMarrow(ct, body, dense, OpenIn(spine, ct.geometry), options, num_threads), dense,
      num_threads);
  context.Checkpoint("finding the skin", 0.8);
  OuterLayer layer = OuterLayerOf(whole_body, unseen, options.skin_thickness_mm, num_threads);
  const bool is_cut = Count(layer.cut) > 0;
  layer = {Cropped(layer.skin, box), Cropped(layer.cut, box)};
  TissuesFound found{volume::LabelMap(whole.geometry), ScanOf(ct, body, dense, options)};
  found.scan.field = field;
  found.scan.has_spine = spine.has_value();
  volume::LabelMap& labels = found.labels;
  const auto& size = ct.geometry.size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const std::size_t at = ct.geometry.Index(i, j, k);
        if (body.voxels[at] == 0) continue;
        volume::Label& label = labels.At(box.low[0] + i, box.low[1] + j, box.low[2] + k);
        label = LabelAt(at, ct, bone, air, layer, options);
        if (spine) label = WithSpine(at, *spine, label);
      }
    }
  }
  for (const char* name : {"skin", "fat", "soft_tissue", "bone", "lung", "gas"}) {
    labels.names[volume::LabelOf(name)] = name;
  }
  if (is_cut) labels.names[volume::LabelOf("cut")] = "cut";
  if (spine) {
    for (const char* name : {"spinal_canal", "disc", "ligament", "muscle"}) {
      labels.names[volume::LabelOf(name)] = name;
    }
  }
  if (spine) FillBodies(whole, labels);
  context.Checkpoint("finding the skin", 1.0);
  return found;
}

}  // namespace acus::segmentation
