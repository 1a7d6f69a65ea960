#include "acus/patient/segmentation/tissues.h"

#include <algorithm>

#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/crop.h"
#include "acus/patient/segmentation/spine.h"

namespace acus::segmentation {
namespace {

/// The outermost layer of the body; where the border of the volume cuts the body there is no skin.
Mask SkinOf(const Mask& body, double thickness_mm, int num_threads) {
  // At least one voxel, so that a coarse CT has a skin too.
  const double voxel_mm = 1.01 * body.geometry.spacing_mm.minCoeff();
  const Mask inner = Eroded(body, std::max(thickness_mm, voxel_mm), num_threads);
  Mask skin(body.geometry);
  for (std::size_t i = 0; i < skin.voxels.size(); ++i) {
    skin.voxels[i] = body.voxels[i] != 0 && inner.voxels[i] == 0 ? 1 : 0;
  }
  return skin;
}

volume::Label LabelAt(std::size_t i, const volume::CtVolume& ct, const Mask& bone,
                      const AirSpaces& air, const Mask& skin, const TissueOptions& options) {
  static const volume::Label kSkin = volume::LabelOf("skin");
  static const volume::Label kFat = volume::LabelOf("fat");
  static const volume::Label kSoft = volume::LabelOf("soft_tissue");
  static const volume::Label kBone = volume::LabelOf("bone");
  static const volume::Label kLung = volume::LabelOf("lung");
  static const volume::Label kGas = volume::LabelOf("gas");
  if (bone.voxels[i] != 0) return kBone;
  if (air.lung.voxels[i] != 0) return kLung;
  // Air within the outermost layer is the rounded edge of the body, not a cavity.
  if (skin.voxels[i] != 0) return kSkin;
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

}  // namespace

int MedianHu(std::vector<std::int16_t>& values) {
  if (values.empty()) return -1024;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

volume::LabelMap FindTissues(const volume::CtVolume& whole, const TissueOptions& options,
                             const RunContext& context) {
  const int num_threads = context.num_threads;
  context.Checkpoint("finding the body", 0.0);
  const Mask whole_body = FindBody(whole, options, num_threads);
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
  const Mask skin = Cropped(SkinOf(whole_body, options.skin_thickness_mm, num_threads), box);
  volume::LabelMap labels(whole.geometry);
  const auto& size = ct.geometry.size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const std::size_t at = ct.geometry.Index(i, j, k);
        if (body.voxels[at] == 0) continue;
        volume::Label& label = labels.At(box.low[0] + i, box.low[1] + j, box.low[2] + k);
        label = LabelAt(at, ct, bone, air, skin, options);
        if (spine) label = WithSpine(at, *spine, label);
      }
    }
  }
  for (const char* name : {"skin", "fat", "soft_tissue", "bone", "lung", "gas"}) {
    labels.names[volume::LabelOf(name)] = name;
  }
  if (spine) {
    for (const char* name : {"spinal_canal", "disc", "ligament", "muscle"}) {
      labels.names[volume::LabelOf(name)] = name;
    }
  }
  context.Checkpoint("finding the skin", 1.0);
  return labels;
}

}  // namespace acus::segmentation
