#include "acus/patient/phantom/anatomy/shoulder.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/random.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

constexpr double kHeadMm = 24.0;      ///< Radius of the humeral head.
constexpr double kCartilageMm = 1.5;  ///< On the head.
constexpr double kPeribursalFatMm = 1.0;
constexpr double kCuffFromMm = kHeadMm + kCartilageMm;

/// A point at a distance from the centre of the head, `lateral_deg` from straight up towards the
/// arm's outer side, in the coronal plane through it.
Vector3d AroundHead(double radius_mm, double lateral_deg) {
  const double angle = lateral_deg * std::numbers::pi / 180.0;
  return radius_mm * Vector3d(-std::sin(angle), 0.0, std::cos(angle));
}

/// A layer over the head up to `radius_mm`, `half_width_mm` to front and back, above `lowest_mm`
/// and not farther medially than `medial_mm`.
Shape CuffLayer(double radius_mm, double half_width_mm, double lowest_mm, double medial_mm) {
  return {[=](const Vector3d& p) {
            const double edge =
                std::max({std::abs(p.y()) - half_width_mm, lowest_mm - p.z(), p.x() - medial_mm});
            return SmoothIntersection(p.norm() - radius_mm, edge, 1.0);
          },
          Box(Vector3d(-radius_mm, -half_width_mm, lowest_mm) - Vector3d::Ones(),
              Vector3d(medial_mm, half_width_mm, radius_mm) + Vector3d::Ones())};
}

/// Factor near 1 that belongs to the name of a size.
double VaryShoulder(const BodySettings& settings, std::uint64_t seed, const char* name) {
  const double z = RandomStream(seed, std::string("size of shoulder ") + name).Normal();
  return 1.0 + 0.01 * settings.variation_percent * std::clamp(z, -2.5, 2.5);
}

}  // namespace

Shoulder::Shoulder(const BodySettings& settings, std::uint64_t seed)
    : shoulder_(settings.shoulder),
      cortex_mm_(settings.cortical_bone_mm),
      build_(VaryShoulder(settings, seed, "build")),
      tendon_mm_(6.0 * VaryShoulder(settings, seed, "tendon")) {}

double Shoulder::FasciaDistance(const Vector3d& p) const {
  // The greater tuberosity reaches 31 mm from the centre of the head.
  const double side = 31.0 + kPeribursalFatMm + shoulder_.bursa_mm + shoulder_.deltoid_mm;
  const double cap = EllipsoidDistance(p, Vector3d(side, 50.0, 46.0));
  const double arm = CapsuleDistance(p, Vector3d(-6, 2, -25), Vector3d(-9, 2, -200), side - 7, 40);
  const double trunk = CapsuleDistance(p, Vector3d(50, 8, 5), Vector3d(200, 0, -10), 42.0, 70.0);
  return SmoothUnion(SmoothUnion(cap, arm, 25.0), trunk, 30.0);
}

void Shoulder::AddBones(std::vector<Part>& parts) const {
  const auto add = [&](const char* name, Shape shape) {
    parts.push_back(
        {name, Material::kCancellousBone, Material::kCorticalBone, cortex_mm_, std::move(shape)});
  };
  const Shape head = Ellipsoid(Vector3d::Zero(), Vector3d::Constant(kHeadMm));
  const Shape tuberosity = Ellipsoid(Vector3d(-16, 0, 2), Vector3d(15, 17, 15));
  const Shape shaft = Tube({{0, 0, -5}, {-5, 1, -40}, {-7, 2, -200}}, {20, 14, 12});
  Box humerus = head.bounds_mm;
  humerus.extend(tuberosity.bounds_mm).extend(shaft.bounds_mm);
  add("humerus", {[=](const Vector3d& p) {
                    return SmoothUnion(
                        SmoothUnion(head.distance_mm(p), tuberosity.distance_mm(p), 3.0),
                        shaft.distance_mm(p), 6.0);
                  },
                  humerus});
  add("acromion", {[](const Vector3d& p) {
                     return RoundedBoxDistance(p - Vector3d(13, 8, 39.5), Vector3d(21, 18, 4.5),
                                               4.0);
                   },
                   Box(Vector3d(-9, -11, 34), Vector3d(35, 27, 45))});
  add("clavicle", Tube({{24, -18, 40}, {70, -32, 44}, {140, -40, 36}}, {6, 6, 8}));
  add("glenoid", Ellipsoid(Vector3d(38.5, 2, -2), Vector3d(11, 14, 19)));
  add("scapula", Tube({{44, 5, -2}, {75, 28, -12}, {120, 45, -30}}, {9, 6, 4}));
}

void Shoulder::AddCuff(std::vector<Part>& parts) const {
  const auto add = [&](const char* name, Material material, Shape shape) {
    parts.push_back({name, material, material, 0.0, std::move(shape)});
  };
  const double outside = kCuffFromMm + tendon_mm_;
  if (shoulder_.tear_mm > 0.0) {
    add("tear", Material::kBursa,
        Ellipsoid(AroundHead(kCuffFromMm + 0.5 * tendon_mm_, 40.0),
                  Vector3d(0.5 * shoulder_.tear_mm, 6.0, 0.5 * shoulder_.tear_mm)));
  }
  add("supraspinatus tendon", Material::kTendon, CuffLayer(outside, 13.0, 4.0, 14.0));
  add("supraspinatus", Material::kMuscle,
      Tube({{10, 2, 28}, {45, 12, 24}, {100, 35, 8}}, {5.0, 11, 12}));
  add("tendon of the biceps", Material::kTendon,
      Tube({{8, -22, 16}, {-8, -24.5, 2}, {-12, -19, -60}, {-13, -17, -90}}, {2.5, 2.5, 3, 3}));
  add("subacromial bursa", Material::kBursa,
      CuffLayer(outside + shoulder_.bursa_mm, 18.0, -8.0, 18.0));
  add("peribursal fat", Material::kFat,
      CuffLayer(outside + shoulder_.bursa_mm + kPeribursalFatMm, 19.0, -9.0, 19.0));
}

std::vector<Part> Shoulder::Parts() const {
  std::vector<Part> parts;
  if (shoulder_.calcification_mm > 0.0) {
    const double radius = 0.5 * shoulder_.calcification_mm;
    parts.push_back({"calcification", Material::kCalcification, Material::kCalcification, 0.0,
                     Ellipsoid(PointsOfInterest().at("calcification"),
                               Vector3d(radius, radius, std::min(radius, 0.45 * tendon_mm_)))});
  }
  AddBones(parts);
  const Vector3d towards_joint = Vector3d(0.8, 0.0, 0.6);
  parts.push_back({"cartilage of the head",
                   Material::kCartilage,
                   Material::kCartilage,
                   0.0,
                   {[=](const Vector3d& p) {
                      return std::max(p.norm() - kCuffFromMm, 4.0 - p.dot(towards_joint));
                    },
                    Box(Vector3d::Constant(-kCuffFromMm), Vector3d::Constant(kCuffFromMm))}});
  AddCuff(parts);
  return parts;
}

Landmarks Shoulder::PointsOfInterest() const {
  const double middle = kCuffFromMm + 0.5 * tendon_mm_;
  return {{"bursa", AroundHead(kCuffFromMm + tendon_mm_ + 0.5 * shoulder_.bursa_mm, 42.0)},
          {"tendon", AroundHead(middle, 25.0)},
          {"calcification", AroundHead(middle, 30.0)},
          {"tear", AroundHead(middle, 40.0)},
          {"joint", Vector3d(25.8, -2.0, 4.0)}};
}

}  // namespace acus::phantom
