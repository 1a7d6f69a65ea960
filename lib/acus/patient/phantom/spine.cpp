// Vertebrae T7 to L5 and sacrum, discs, ligaments, the spinal canal.
//
// Sizes follow the usual morphometry of lumbar vertebrae (body 45 x 34 x 27 mm, canal 23 x 16 mm,
// transverse processes 90 mm from tip to tip): see docs/models/phantom.md.
#include <algorithm>
#include <cmath>

#include "acus/patient/phantom/anatomy/trunk.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

/// One vertebra; lengths mm.
struct Level {
  const char* name;
  double z;             ///< Height of the middle of the body.
  double half_height;   ///< Of the body.
  double half_width;    ///< Of the body.
  double half_depth;    ///< Of the body.
  double transverse;    ///< Reach of the transverse process from the midline.
  double spinous_y;     ///< Reach of the spinous process behind the body.
  double spinous_drop;  ///< How far its tip lies below the middle of the body.
  double spinous_half_height;
};

constexpr Level kLevels[] = {
    {"L5", -53, 13.0, 24.5, 17.0, 44, 46, 11, 8},   {"L4", -18, 13.5, 24.0, 17.0, 44, 51, 12, 9.5},
    {"L3", 18, 13.5, 23.0, 17.0, 47, 53, 12, 10.5}, {"L2", 54, 13.5, 22.0, 16.5, 43, 53, 12, 10.5},
    {"L1", 89, 13.0, 21.0, 16.0, 39, 51, 12, 10},   {"T12", 121, 12.5, 20.5, 15.5, 26, 50, 14, 9},
    {"T11", 150, 12.0, 19.5, 15.5, 27, 51, 19, 7},  {"T10", 178, 11.5, 18.5, 15.0, 30, 52, 25, 6},
    {"T9", 204, 11.0, 17.5, 14.5, 32, 52, 28, 5},   {"T8", 229, 10.5, 16.5, 14.0, 33, 52, 30, 5},
    {"T7", 253, 10.0, 16.0, 13.5, 33, 52, 30, 5},
};
constexpr double kSacrumZ = -90.0;
constexpr double kLaminaTop = 6.0;  ///< Of the upper edge of a lamina above the middle of the body.

/// The frame of a vertebra: origin on the back wall of its body, +z along the canal.
Eigen::Isometry3d Frame(const Builder& builder, double z) {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  frame.linear() = Eigen::AngleAxisd(-std::atan(builder.trunk.SpineSlope(z)), Vector3d::UnitX())
                       .toRotationMatrix();
  frame.translation() = Vector3d(0.0, builder.trunk.SpineY(z), z);
  return frame;
}

/// Body: an elliptic drum with a waist, a hollow back wall and rounded rims.
double BodyDistance(const Vector3d& p, const Level& v) {
  const double h = std::min(std::abs(p.z()) / v.half_height, 1.0);
  const double waist = 1.0 - 0.10 * (1.0 - h * h);
  const Vector3d q(p.x() / waist, (p.y() + v.half_depth) / waist, 0.0);
  const double side = waist * EllipsoidDistance(q, Vector3d(v.half_width, v.half_depth + 1.0, 1e6));
  return SmoothIntersection(side, std::abs(p.z()) - v.half_height, 3.0);
}

/// Pedicle, pillar, lamina, transverse process of one side, by symmetry for x >= 0.
double ArchDistance(const Vector3d& p, const Level& v, double lamina_bottom) {
  const Vector3d q(std::abs(p.x()), p.y(), p.z());
  // The pedicle is taller than wide: squeeze z.
  const Vector3d tall(1.0, 1.0, 0.62);
  const double pedicle = CapsuleDistance(q.cwiseProduct(tall), Vector3d(15, -5, 3.5),
                                         Vector3d(15.5, 9, 3.5), 4.6, 4.8);
  // Half-way down the roof: laminae slope backwards on their way down, as tiles do.
  const double mid_z = 0.5 * (kLaminaTop + lamina_bottom);
  const double half = 0.5 * (kLaminaTop - lamina_bottom);
  const double y = q.y() - 17.8 + 0.16 * (q.z() - mid_z) - 0.42 * (9.0 - q.x());
  const double lamina = RoundedBoxDistance(Vector3d(q.x() - 8.0, 0.92 * y, q.z() - mid_z),
                                           Vector3d(10.0, 3.0, half), 2.9);
  const double upper = CapsuleDistance(q, Vector3d(18, 12, 3), Vector3d(20.5, 13, 17.5), 5.5, 3.8);
  const double lower =
      CapsuleDistance(q, Vector3d(15.5, 16, 0), Vector3d(13.5, 20.5, lamina_bottom - 4), 5.2, 4.2);
  const Vector3d flat(1.0, 1.25, 0.8);
  const double transverse = CapsuleDistance(q.cwiseProduct(flat), Vector3d(17, 12, 2.4),
                                            Vector3d(v.transverse - 4.0, 14, 2.4), 5.0, 3.6);
  const double arch =
      SmoothUnion(SmoothUnion(pedicle, lamina, 3.0), SmoothUnion(upper, lower, 4.0), 3.0);
  return SmoothUnion(arch, transverse, 3.0);
}

/// Spinous process: a blade that gets thicker at its tip.
double SpinousDistance(const Vector3d& p, const Level& v) {
  const double start = 21.0;
  const double t = std::clamp((p.y() - start) / (v.spinous_y - start), 0.0, 1.0);
  const double z = -6.0 + t * (6.0 - v.spinous_drop);
  const double half_thickness = 2.8 + 2.2 * t * t;
  const double mid_y = 0.5 * (start + v.spinous_y);
  return RoundedBoxDistance(
      Vector3d(p.x(), p.y() - mid_y, p.z() - z),
      Vector3d(half_thickness, 0.5 * (v.spinous_y - start), v.spinous_half_height), 2.7);
}

/// The canal in a vertebra's frame: wide and flat, with a corner towards the spinous process.
double CanalDistance(const Vector3d& p) {
  const double oval =
      EllipsoidDistance(Vector3d(p.x(), p.y() - 6.8, 0.0), Vector3d(11.5, 7.8, 1e6));
  const double corner =
      EllipsoidDistance(Vector3d(p.x(), p.y() - 11.5, 0.0), Vector3d(6.0, 6.5, 1e6));
  return SmoothUnion(oval, corner, 4.0);
}

double SacDistance(const Vector3d& p) {
  return EllipsoidDistance(Vector3d(p.x(), p.y() - 6.4, 0.0), Vector3d(8.5, 6.4, 1e6));
}

void AddVertebra(Builder& builder, const Level& level, double gap_below, double pitch) {
  Level v = level;
  v.half_width *= builder.Vary(v.name, 1);
  v.half_depth *= builder.Vary(v.name, 2);
  v.transverse *= builder.Vary(v.name, 3);
  const double lamina_bottom = kLaminaTop - pitch + gap_below;
  const Shape local{[=](const Vector3d& p) {
                      const double arch = SmoothUnion(ArchDistance(p, v, lamina_bottom),
                                                      SpinousDistance(p, v), 3.0);
                      const double bone = SmoothUnion(BodyDistance(p, v), arch, 3.0);
                      return std::max(bone, -CanalDistance(p));
                    },
                    Box(Vector3d(-v.transverse - 2, -2 * v.half_depth - 3, -v.spinous_drop - 25),
                        Vector3d(v.transverse + 2, v.spinous_y + 3, 24))};
  Eigen::Isometry3d frame = Frame(builder, v.z);
  RandomStream random(builder.seed, "pose of vertebra", static_cast<std::uint64_t>(v.z + 1000.0));
  const double turn = 0.6 * builder.settings.variation_percent * std::numbers::pi / 180.0;
  frame.rotate(Eigen::AngleAxisd(turn * random.Uniform(-1, 1), Vector3d::UnitZ()));
  builder.AddShelled(v.name, Material::kCancellousBone, Material::kCorticalBone,
                     builder.settings.cortical_bone_mm, Moved(local, frame));
  builder.landmarks[std::string("lamina_") + v.name] = frame * Vector3d(9, 21, 0.5 * lamina_bottom);
}

/// Disc and ligaments between `upper` and the level below, whose body is centred at `lower_z`.
void AddInterspace(Builder& builder, const Level& upper, double lower_z, double lower_half_height,
                   const std::string& name) {
  const double top = upper.z - upper.half_height;
  const double bottom = lower_z + lower_half_height;
  const double z = 0.5 * (top + bottom);
  const Eigen::Isometry3d frame = Frame(builder, z);
  const double half = 0.5 * (upper.z - lower_z);
  const Vector3d radii(upper.half_width, upper.half_depth + 1.0, 1e6);
  const Shape disc{
      [=](const Vector3d& p) {
        const double side = EllipsoidDistance(Vector3d(p.x(), p.y() + radii.y() - 1, 0), radii);
        return SmoothIntersection(side, std::abs(p.z()) - 0.5 * (top - bottom) - 2.0, 2.0);
      },
      Box(Vector3d(-30, -40, -12), Vector3d(30, 5, 12))};
  builder.Add("disc " + name, Material::kDisc, Moved(disc, frame));
  const Shape flavum{[=](const Vector3d& p) {
                       const double y = p.y() - 17.6 - 0.42 * (9.0 - std::abs(p.x()));
                       return RoundedBoxDistance(Vector3d(p.x(), 0.92 * y, p.z()),
                                                 Vector3d(16.0, 2.0, half), 1.0);
                     },
                     Box(Vector3d(-17, 10, -half), Vector3d(17, 25, half))};
  builder.Add("ligamentum flavum " + name, Material::kLigament, Moved(flavum, frame));
  const Shape interspinous{[=](const Vector3d& p) {
                             return RoundedBoxDistance(p - Vector3d(0, 38, -10),
                                                       Vector3d(2.2, 15, half), 2.0);
                           },
                           Box(Vector3d(-3, 22, -half - 10), Vector3d(3, 54, half - 10))};
  builder.Add("interspinous ligament " + name, Material::kLigament, Moved(interspinous, frame));
  builder.landmarks["canal_" + name] = frame * Vector3d(0, 7.5, -2.0);
  builder.landmarks["disc_" + name] = frame * Vector3d(0, -17, 0);
}

/// Canal, sac and the ligament over the tips of the spinous processes run along the whole spine.
void AddCanal(Builder& builder) {
  const Trunk trunk = builder.trunk;
  const auto straight = [trunk](const Vector3d& p) {
    const double slope = trunk.SpineSlope(p.z());
    return Vector3d(p.x(), (p.y() - trunk.SpineY(p.z())) / std::sqrt(1.0 + slope * slope), 0.0);
  };
  const Box reach(Vector3d(-13, -5, -130), Vector3d(13, 90, 300));
  builder.Add("thecal sac", Material::kThecalSac,
              {[=](const Vector3d& p) { return SacDistance(straight(p)); }, reach});
  builder.Add("epidural fat", Material::kEpiduralFat,
              {[=](const Vector3d& p) { return CanalDistance(straight(p)); }, reach});
  builder.Add("supraspinous ligament", Material::kLigament,
              {[=](const Vector3d& p) {
                 return EllipsoidDistance(straight(p) - Vector3d(0, 54.0, 0),
                                          Vector3d(4.0, 2.5, 1e6));
               },
               reach});
}

Eigen::Isometry3d SacrumFrame(const Builder& builder) {
  Eigen::Isometry3d frame = Frame(builder, kSacrumZ);
  frame.rotate(Eigen::AngleAxisd(-0.35, Vector3d::UnitX()));
  return frame;
}

/// The canal in the frame of the sacrum.
double SacralCanalDistance(const Vector3d& p) {
  return EllipsoidDistance(Vector3d(p.x(), p.y() - 7.5, 0), Vector3d(11, 6.5, 1e6));
}

/// Fat in what the sacrum leaves open beside and below the canal of the lumbar spine.
void AddSacralCanal(Builder& builder) {
  const Shape local{[](const Vector3d& p) { return SacralCanalDistance(p); },
                    Box(Vector3d(-12, 0, -72), Vector3d(12, 15, 4))};
  builder.Add("sacral canal", Material::kEpiduralFat, Moved(local, SacrumFrame(builder)));
}

/// A wedge that leans backwards, with its canal and the wings that meet the iliac bones.
void AddSacrum(Builder& builder) {
  const Shape local{
      [](const Vector3d& p) {
        const double shrink = std::clamp(1.0 + 0.006 * p.z(), 0.4, 1.1);
        const double body = RoundedBoxDistance(p - Vector3d(0, -13, -28),
                                               Vector3d(23 * shrink, 14 * shrink, 40), 8);
        const Vector3d q(std::abs(p.x()), p.y(), p.z());
        const double wing =
            EllipsoidDistance(q - Vector3d(30 * shrink, -2, -22), Vector3d(22, 15, 34));
        const double crest = RoundedBoxDistance(p - Vector3d(0, 22, -22), Vector3d(5, 9, 32), 3);
        const double roof = RoundedBoxDistance(p - Vector3d(0, 18, -26), Vector3d(17, 4, 30), 3);
        const double bone = SmoothUnion(SmoothUnion(body, wing, 6), SmoothUnion(crest, roof, 4), 4);
        return std::max(bone, -SacralCanalDistance(p));
      },
      Box(Vector3d(-56, -32, -72), Vector3d(56, 36, 16))};
  builder.AddShelled("sacrum", Material::kCancellousBone, Material::kCorticalBone,
                     builder.settings.cortical_bone_mm, Moved(local, SacrumFrame(builder)));
}

}  // namespace

void AddSpine(Builder& builder) {
  constexpr int kNumLevels = static_cast<int>(std::size(kLevels));
  for (int i = 0; i < kNumLevels; ++i) {
    const Level& v = kLevels[i];
    const double lower_z = i == 0 ? kSacrumZ + 2.0 : kLevels[i - 1].z;
    const bool lumbar = v.name[0] == 'L';
    // Thoracic laminae overlap nearly: there is no window between them.
    AddVertebra(builder, v, lumbar ? builder.settings.interlaminar_gap_mm : 5.0, v.z - lower_z);
  }
  AddSacrum(builder);
  AddCanal(builder);
  AddSacralCanal(builder);
  for (int i = 0; i < kNumLevels; ++i) {
    const bool last = i == 0;
    AddInterspace(builder, kLevels[i], last ? kSacrumZ + 2.0 : kLevels[i - 1].z,
                  last ? 9.0 : kLevels[i - 1].half_height,
                  std::string(kLevels[i].name) + (last ? "S1" : kLevels[i - 1].name));
  }
}

}  // namespace acus::phantom
