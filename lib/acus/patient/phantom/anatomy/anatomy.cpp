#include "acus/patient/phantom/anatomy/anatomy.h"

#include <algorithm>
#include <array>
#include <memory>

#include "acus/data/volume/labels.h"
#include "acus/patient/phantom/anatomy/shoulder.h"
#include "acus/patient/phantom/anatomy/trunk.h"

namespace acus::phantom {
namespace {

constexpr std::array<MaterialInfo, kNumMaterials> kMaterials = {{
    {"air", "outside"},
    {"skin", "skin"},
    {"fat", "fat"},
    {"muscle", "muscle"},
    {"cortical_bone", "bone"},
    {"cancellous_bone", "bone"},
    {"disc", "disc"},
    {"ligament", "ligament"},
    {"epidural_fat", "spinal_canal"},
    {"thecal_sac", "spinal_canal"},
    {"cartilage", "cartilage"},
    {"lung", "lung"},
    {"liver", "liver"},
    {"lesion", "lesion"},
    {"vessel", "vessel"},
    {"kidney", "kidney"},
    {"spleen", "spleen"},
    {"bowel", "bowel"},
    {"gas", "gas"},
    {"stomach", "stomach"},
    {"gallbladder", "gallbladder"},
    {"pancreas", "pancreas"},
    {"heart", "heart"},
    {"tendon", "tendon"},
    {"bursa", "bursa"},
    {"calcification", "bone"},
    {"urine", "bladder"},
    {"cyst", "gallbladder"},
}};

std::array<volume::Label, kNumMaterials> LabelTable() {
  std::array<volume::Label, kNumMaterials> table{};
  std::ranges::transform(kMaterials, table.begin(),
                         [](const MaterialInfo& m) { return volume::LabelOf(m.label); });
  return table;
}

}  // namespace

std::span<const MaterialInfo> Materials() {
  return kMaterials;
}

volume::Label LabelOf(Material material) {
  static const std::array<volume::Label, kNumMaterials> kTable = LabelTable();
  return kTable[static_cast<std::size_t>(material)];
}

Anatomy::Anatomy(const BodySettings& settings, std::uint64_t seed) : skin_mm_(settings.skin_mm) {
  if (settings.region == BodySettings::Region::kShoulder) {
    AddShoulder(settings, seed);
  } else {
    AddTrunk(settings, seed);
  }
  for (auto& [name, point] : landmarks_) point *= scale_;
}

void Anatomy::AddTrunk(const BodySettings& settings, std::uint64_t seed) {
  const auto trunk = std::make_shared<const Trunk>(settings);
  Builder builder{*trunk, settings, seed, parts_, landmarks_};
  scale_ = settings.scale * builder.Vary("body");
  AddSpine(builder);
  AddRibs(builder);
  AddPelvis(builder);
  AddMuscles(builder);
  AddLesion(builder);
  AddBileDucts(builder);
  AddVessels(builder);
  AddOrgans(builder);
  AddBowel(builder);
  skin_ = [trunk](const Eigen::Vector3d& p) { return trunk->SkinDistance(p); };
  fascia_ = [trunk](const Eigen::Vector3d& p) { return trunk->FasciaDistance(p); };
  cavity_ = [trunk](const Eigen::Vector3d& p) { return trunk->CavityDistance(p); };
}

void Anatomy::AddShoulder(const BodySettings& settings, std::uint64_t seed) {
  const Shoulder shoulder(settings, seed);
  scale_ = settings.scale * shoulder.build();
  parts_ = shoulder.Parts();
  landmarks_ = shoulder.PointsOfInterest();
  const double under_skin_mm = settings.subcutaneous_fat_mm + settings.skin_mm;
  fascia_ = [shoulder](const Eigen::Vector3d& p) { return shoulder.FasciaDistance(p); };
  skin_ = [fascia = fascia_, under_skin_mm](const Eigen::Vector3d& p) {
    return fascia(p) - under_skin_mm;
  };
  // Everything under the fascia that is nothing else is deltoid, or muscle beside it.
  cavity_ = [](const Eigen::Vector3d&) { return 1.0; };
}

Material Anatomy::MaterialAt(const Eigen::Vector3d& point_ct_mm, const Nearby& parts) const {
  const Eigen::Vector3d p = point_ct_mm / scale_;
  const double skin_mm = skin_(p) * scale_;
  if (skin_mm > 0.0) return Material::kAir;
  if (skin_mm > -skin_mm_) return Material::kSkin;
  for (const Part* part : parts) {
    if (!part->shape.bounds_mm.contains(p)) continue;
    const double distance = part->shape.distance_mm(p);
    if (distance < 0.0) return distance < -part->shell_mm ? part->core : part->shell;
  }
  if (fascia_(p) > 0.0) return Material::kFat;
  return cavity_(p) > 0.0 ? Material::kMuscle : Material::kFat;
}

Material Anatomy::MaterialAt(const Eigen::Vector3d& point_ct_mm) const {
  return MaterialAt(point_ct_mm, PartsIn(Box(point_ct_mm, point_ct_mm)));
}

double Anatomy::SkinDistanceMm(const Eigen::Vector3d& point_ct_mm) const {
  return skin_(point_ct_mm / scale_) * scale_;
}

Anatomy::Nearby Anatomy::PartsIn(const Box& box_ct_mm) const {
  const Box box(box_ct_mm.min() / scale_, box_ct_mm.max() / scale_);
  Nearby near;
  for (const Part& part : parts_) {
    if (part.shape.bounds_mm.intersects(box)) near.push_back(&part);
  }
  return near;
}

const Eigen::Vector3d& Anatomy::Landmark(const std::string& name) const {
  const auto found = landmarks_.find(name);
  if (found != landmarks_.end()) return found->second;
  std::string known;
  for (const auto& [other, point] : landmarks_) known += " " + other;
  throw InputError(Message("no landmark is named '", name, "'; known:", known));
}

}  // namespace acus::phantom
