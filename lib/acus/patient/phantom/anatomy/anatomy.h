// A synthetic patient as implicit shapes: what is at any point, exactly.
//
// CT space is LPS, mm: +x to the patient's left, +y to the back, +z to the head. The origin of a
// trunk lies on the back wall of the vertebral bodies, in the middle of the disc L3/L4; that of a
// right shoulder in the centre of the humeral head.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acus/data/volume/volume.h"
#include "acus/patient/phantom/anatomy/shapes.h"

namespace acus::phantom {

/// What a point is made of. Finer than labels: bone is cortical or cancellous, the canal holds fat
/// around the thecal sac.
enum class Material : std::uint8_t {
  kAir,
  kSkin,
  kFat,
  kMuscle,
  kCorticalBone,
  kCancellousBone,
  kDisc,
  kLigament,
  kEpiduralFat,
  kThecalSac,
  kCartilage,
  kLung,
  kLiver,
  kLesion,
  kVessel,
  kKidney,
  kSpleen,
  kBowel,
  kGas,
  kStomach,
  kGallbladder,
  kPancreas,
  kHeart,
  kTendon,
  kBursa,
  kCalcification,
  kUrine,
  kCyst,
};
inline constexpr int kNumMaterials = static_cast<int>(Material::kCyst) + 1;

/// Name as in configs/phantoms and the standard label it belongs to.
struct MaterialInfo {
  std::string_view name;
  std::string_view label;
};
std::span<const MaterialInfo> Materials();  ///< By Material.
volume::Label LabelOf(Material material);

/// What is healthy or ill in a shoulder; lengths before scale.
struct ShoulderSettings {
  double deltoid_mm = 17.0;       ///< Thickness over the greater tuberosity.
  double bursa_mm = 1.5;          ///< Subacromial bursa; an effusion makes it 4 to 10 mm.
  double calcification_mm = 0.0;  ///< Diameter of a deposit in the supraspinatus tendon; 0: none.
  double tear_mm = 0.0;           ///< Length of a full-thickness tear at its insertion; 0: none.
};

/// The build of the body; from configs/phantoms (section "body").
struct BodySettings {
  enum class Region { kTrunk, kShoulder };
  Region region = Region::kTrunk;
  ShoulderSettings shoulder;
  double scale = 1.0;                 ///< All lengths, relative to a man of about 1.75 m.
  double variation_percent = 3.0;     ///< Standard deviation of sizes between seeds.
  double skin_mm = 2.0;               ///< Thickness of the skin.
  double subcutaneous_fat_mm = 15.0;  ///< At the flank; 0.8 times that at the back.
  double interlaminar_gap_mm = 13.0;  ///< Height of the lumbar windows in the midline.
  double cortical_bone_mm = 1.5;      ///< Thickness of the dense outer layer of bone.
  Eigen::Vector3d lesion_centre_mm;   ///< Of the liver lesion, before scale and variation.
  double lesion_radius_mm = 11.0;
  double bile_duct_mm = 0.0;   ///< Diameter of dilated ducts of the liver; 0: too thin to be seen.
  double liver_cyst_mm = 0.0;  ///< Diameter of a cyst in the place of the liver lesion; 0: none.
  double renal_pelvis_mm = 0.0;  ///< Thickness of a dilated right renal pelvis; 0: not dilated.
};

/// One organ or bone. A layer `shell_mm` thick under its surface is of another material.
struct Part {
  std::string name;
  Material core;
  Material shell;
  double shell_mm;
  Shape shape;
};

/// Named points on the exact anatomy, CT mm.
using Landmarks = std::map<std::string, Eigen::Vector3d>;

class Anatomy {
 public:
  Anatomy(const BodySettings& settings, std::uint64_t seed);

  Material MaterialAt(const Eigen::Vector3d& point_ct_mm) const;
  volume::Label LabelAt(const Eigen::Vector3d& point_ct_mm) const {
    return LabelOf(MaterialAt(point_ct_mm));
  }

  /// Distance to the skin's outer surface, mm, > 0 outside the body; first order.
  double SkinDistanceMm(const Eigen::Vector3d& point_ct_mm) const;

  /// For many points in one box: the parts that reach into it, and what is at a point of the box.
  using Nearby = std::vector<const Part*>;
  Nearby PartsIn(const Box& box_ct_mm) const;
  Material MaterialAt(const Eigen::Vector3d& point_ct_mm, const Nearby& parts) const;

  const Landmarks& landmarks() const { return landmarks_; }
  /// @throws InputError naming the known ones.
  const Eigen::Vector3d& Landmark(const std::string& name) const;
  const std::vector<Part>& parts() const { return parts_; }  ///< Highest priority first.
  double scale() const { return scale_; }                    ///< CT mm per mm of `parts`.

 private:
  void AddTrunk(const BodySettings& settings, std::uint64_t seed);
  void AddShoulder(const BodySettings& settings, std::uint64_t seed);

  double scale_;
  double skin_mm_;
  Distance skin_, fascia_, cavity_;
  std::vector<Part> parts_;
  Landmarks landmarks_;
};

}  // namespace acus::phantom
