// Liver with lesion, kidneys, spleen, stomach, lungs, heart, muscles of the back.
#include <algorithm>
#include <cmath>

#include "acus/patient/phantom/anatomy/trunk.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

const Box kWholeTrunk(Vector3d(-200, -200, -150), Vector3d(200, 150, 300));

Eigen::Matrix3d Rotation(double about_x_deg, double about_y_deg, double about_z_deg) {
  constexpr double kRad = std::numbers::pi / 180.0;
  return (Eigen::AngleAxisd(about_z_deg * kRad, Vector3d::UnitZ()) *
          Eigen::AngleAxisd(about_y_deg * kRad, Vector3d::UnitY()) *
          Eigen::AngleAxisd(about_x_deg * kRad, Vector3d::UnitX()))
      .toRotationMatrix();
}

/// Height above the diaphragm along its steepest direction, about.
double AboveDiaphragm(const Vector3d& p) {
  return 0.62 * (p.z() - DiaphragmZ(p.x(), p.y()));
}

/// The liver fills the right dome: bounded by chest wall, diaphragm, a rising under side, and at
/// the back by the spine and the great vessels.
Shape Liver(const Trunk& trunk) {
  const Profile bottom{{-130, 52}, {-95, 56}, {-60, 88}, {-20, 122}, {25, 150}, {75, 182}};
  const Profile back{{-75, 70}, {-45, 12}, {-22, -36}, {10, -58}, {75, -84}};
  return {[=, &trunk](const Vector3d& p) {
            const double wall = trunk.CavityDistance(p) + 1.5;
            const double top = AboveDiaphragm(p) + 2.0;
            const double slope = bottom.Slope(p.x());
            const double under =
                (bottom(p.x()) - 0.12 * (p.y() + 50.0) - p.z()) / std::sqrt(1.0 + slope * slope);
            const double behind = (p.y() - back(p.x())) / std::hypot(1.0, back.Slope(p.x()));
            const double left = 0.8 * (p.x() - 78.0);
            return SmoothIntersection(
                SmoothIntersection(wall, top, 10.0),
                SmoothIntersection(SmoothIntersection(under, behind, 22.0), left, 25.0), 14.0);
          },
          Box(Vector3d(-140, -130, 40), Vector3d(80, 75, 220))};
}

/// A bean: an ellipsoid with a notch towards the spine. `side` is -1 right, +1 left.
Shape Kidney(double side, double z, double size) {
  const Eigen::Matrix3d turn = Rotation(-10.0, side * -12.0, side * 25.0);
  const Vector3d centre(side * 62.0, 6.0, z);
  const Vector3d radii = size * Vector3d(26.0, 23.0, 55.0);
  const Shape whole = Ellipsoid(centre, radii, turn);
  const Vector3d notch = centre - turn * Vector3d(side * 24.0, 6.0, 0.0);
  return {[=](const Vector3d& p) {
            const double hollow =
                EllipsoidDistance(turn.transpose() * (p - notch), Vector3d(18, 12, 24));
            return SmoothIntersection(whole.distance_mm(p), -hollow, 4.0);
          },
          whole.bounds_mm};
}

/// Dilated renal pelvis with three calyces, within the kidney of Kidney(-1, z, ...).
void AddRenalPelvis(Builder& builder, double z) {
  const double thickness_mm = builder.settings.renal_pelvis_mm;
  if (thickness_mm <= 0.0) return;
  const Eigen::Matrix3d turn = Rotation(-10.0, 12.0, -25.0);
  const auto at = [&](double lateral, double back, double up) -> Vector3d {
    return Vector3d(-62.0, 6.0, z) + turn * Vector3d(-lateral, back, up);
  };
  const double radius = 0.5 * thickness_mm;
  const Vector3d pelvis = at(-8.0, 0.0, 0.0);
  builder.Add("renal pelvis", Material::kUrine,
              Ellipsoid(pelvis, Vector3d(1.2 * radius, radius, 1.8 * radius), turn));
  const Vector3d lower = at(6.0, -7.0, -22.0);
  for (const Vector3d& calyx : {lower, at(8.0, 2.0, 0.0), at(6.0, 2.0, 26.0)}) {
    builder.Add("calyx", Material::kUrine, Tube({pelvis, calyx}, {0.5 * radius, 0.7 * radius}));
  }
  builder.landmarks["lower_calyx"] = lower;
}

void AddKidneys(Builder& builder) {
  for (const double side : {-1.0, 1.0}) {
    const std::string name = side < 0 ? "right kidney" : "left kidney";
    const double z = (side < 0 ? 66.0 : 80.0) + 100.0 * (builder.Vary(name, 1) - 1.0);
    const Shape kidney = Kidney(side, z, builder.Vary(name));
    if (side < 0) AddRenalPelvis(builder, z);
    builder.Add(name, Material::kKidney, kidney);
    const Shape capsule = Ellipsoid(Vector3d(side * 62.0, 6.0, z), Vector3d(33, 29, 65),
                                    Rotation(-10.0, side * -12.0, side * 25.0));
    builder.Add("fat of " + name, Material::kFat, capsule);
    builder.landmarks[side < 0 ? "right_kidney" : "left_kidney"] =
        Vector3d(side * 66.0, 8.0, z + 25.0);
  }
}

void AddLungs(Builder& builder) {
  const Trunk& trunk = builder.trunk;
  const Shape heart = Ellipsoid(Vector3d(18, -62, 250), Vector3d(58, 42, 50), Rotation(0, 15, -25));
  builder.Add("heart", Material::kHeart, heart);
  builder.Add("mediastinum", Material::kFat,
              {[](const Vector3d& p) {
                 return EllipsoidDistance(Vector3d(p.x() - 2.0, p.y() + 22.0, 0.0),
                                          Vector3d(24, 52, 1e6));
               },
               Box(Vector3d(-24, -76, 140), Vector3d(28, 32, 300))});
  builder.Add("lungs", Material::kLung,
              {[&trunk](const Vector3d& p) {
                 return SmoothIntersection(trunk.CavityDistance(p) + 2.0, 2.0 - AboveDiaphragm(p),
                                           3.0);
               },
               Box(Vector3d(-160, -140, 90), Vector3d(160, 80, 300))});
}

}  // namespace

void AddLesion(Builder& builder) {
  const Vector3d centre = builder.settings.lesion_centre_mm;
  if (builder.settings.liver_cyst_mm > 0.0) {
    builder.Add("liver cyst", Material::kCyst,
                Ellipsoid(centre, Vector3d::Constant(0.5 * builder.settings.liver_cyst_mm)));
    builder.landmarks["cyst"] = centre;
    return;
  }
  const double radius = builder.settings.lesion_radius_mm;
  builder.Add("liver lesion", Material::kLesion, Ellipsoid(centre, Vector3d::Constant(radius)));
  builder.landmarks["lesion"] = centre;
}

void AddOrgans(Builder& builder) {
  const Trunk& trunk = builder.trunk;
  builder.Add("gallbladder", Material::kGallbladder,
              Ellipsoid(Vector3d(-48, -92, 92), builder.Vary("gallbladder") * Vector3d(15, 14, 27),
                        Rotation(35, 10, 0)));
  AddKidneys(builder);
  const Shape spleen = Ellipsoid(
      Vector3d(92, 0, 150), builder.Vary("spleen") * Vector3d(24, 40, 52), Rotation(-20, 12, -25));
  builder.Add("spleen", Material::kSpleen,
              {[=, &trunk](const Vector3d& p) {
                 return SmoothIntersection(spleen.distance_mm(p), trunk.CavityDistance(p) + 1.5,
                                           8.0);
               },
               spleen.bounds_mm});
  builder.Add("liver", Material::kLiver, Liver(trunk));
  builder.landmarks["liver"] = Vector3d(-80, -30, 150);
  builder.Add("pancreas", Material::kPancreas,
              Tube({{-32, -66, 78}, {0, -72, 92}, {45, -55, 112}, {72, -28, 126}}, {13, 10, 9, 8}));
  AddLungs(builder);
}

void AddMuscles(Builder& builder) {
  const Trunk& trunk = builder.trunk;
  const Profile psoas_x{{-120, 56}, {-53, 46}, {18, 36}, {89, 25}};
  const Profile psoas_y{{-120, -42}, {-53, -24}, {18, -12}, {89, -8}};
  const Profile psoas_radius{{-120, 21}, {-53, 23}, {18, 17}, {80, 8}, {100, 3}};
  const double build = builder.Vary("muscle");
  std::vector<Shape> sheaths;
  const auto add = [&](const std::string& name, const Shape& muscle) {
    builder.Add(name, Material::kMuscle, muscle);
    sheaths.push_back(muscle);
  };
  add("psoas", {[=, &trunk](const Vector3d& p) {
                  const double r = psoas_radius(p.z()) * build;
                  return EllipsoidDistance(
                      Vector3d(std::abs(p.x()) - psoas_x(p.z()),
                               p.y() - trunk.SpineY(p.z()) - psoas_y(p.z()), 0.0),
                      Vector3d(r, 1.15 * r, 1e6));
                },
                Box(kWholeTrunk.min(), Vector3d(200, 150, 104))});
  const Profile erector_half_width{{-110, 22}, {-53, 31}, {54, 33}, {121, 31}, {250, 26}};
  add("erector spinae", {[=, &trunk](const Vector3d& p) {
                           const double width = erector_half_width(p.z()) * build;
                           const double y = p.y() - trunk.SpineY(p.z()) - 32.0;
                           const double belly =
                               SuperellipseDistance(std::abs(p.x()) - 1.5 - width, y, width, 27.0);
                           return std::max(belly, trunk.FasciaDistance(p) + 1.0);
                         },
                         kWholeTrunk});
  const Profile quadratus_x{{-30, 82}, {60, 66}, {115, 48}};
  const Profile quadratus_size{{-30, 1.1}, {60, 0.9}, {118, 0.35}};
  add("quadratus lumborum", {[=](const Vector3d& p) {
                               const double dx = std::abs(p.x()) - quadratus_x(p.z());
                               const double dy = p.y() - 16.0 + 0.25 * dx;
                               return EllipsoidDistance(
                                   Vector3d(dx, dy, 0.0),
                                   quadratus_size(p.z()) * Vector3d(21, 8, 1e6));
                             },
                             Box(Vector3d(-110, -10, -35), Vector3d(110, 45, 118))});
  // Thin layers of fat between the muscles, as every CT shows them.
  for (const Shape& muscle : sheaths) builder.Add("fat plane", Material::kFat, Grown(muscle, 1.3));
}

}  // namespace acus::phantom
