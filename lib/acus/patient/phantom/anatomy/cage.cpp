// Ribs with their cartilage, and the iliac bones.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/patient/phantom/anatomy/trunk.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

struct Rib {
  const char* name;
  double head_z;        ///< Height at the spine, mm.
  double drop;          ///< How far the front end lies lower, mm.
  double end_azimuth;   ///< Where bone ends; 0 is the back, pi the front.
  double cartilage_to;  ///< Where its cartilage ends, or 0.
};

constexpr Rib kRibs[] = {
    {"7", 264, 108, 2.35, 2.95},  {"8", 240, 110, 2.20, 2.75}, {"9", 215, 108, 2.02, 2.55},
    {"10", 189, 102, 1.85, 2.35}, {"11", 160, 92, 1.45, 0.0},  {"12", 129, 70, 1.02, 0.0},
};
constexpr double kStartAzimuth = 0.42;

/// Middle of the chest wall in which the ribs lie.
Section Wall(const Trunk& trunk, double z) {
  const Section outer = trunk.Fascia(z);
  const Section inner = trunk.Cavity(z);
  const double back = 0.35 * (outer.centre_y_mm + outer.half_depth_mm) +
                      0.65 * (inner.centre_y_mm + inner.half_depth_mm);
  const double front =
      0.5 * (outer.centre_y_mm - outer.half_depth_mm + inner.centre_y_mm - inner.half_depth_mm);
  return {0.45 * outer.half_width_mm + 0.55 * inner.half_width_mm, 0.5 * (back - front),
          0.5 * (back + front)};
}

double RibZ(const Rib& rib, double azimuth) {
  const double s = std::sin(0.5 * azimuth);
  const double rise = rib.cartilage_to > 0.0 ? std::max(azimuth - rib.end_azimuth, 0.0) : 0.0;
  return rib.head_z - rib.drop * s * s + 95.0 * rise * rise;
}

Vector3d RibPoint(const Trunk& trunk, const Rib& rib, double azimuth) {
  const double z = RibZ(rib, azimuth);
  const Section wall = Wall(trunk, z);
  const Eigen::Vector2d xy = SuperellipsePoint(azimuth, wall.half_width_mm, wall.half_depth_mm);
  return {xy.x(), xy.y() + wall.centre_y_mm, z};
}

/// Distance to a band that follows the wall between two azimuths: flat, higher than thick.
double BandDistance(const Trunk& trunk, const Rib& rib, const Vector3d& p, double from, double to) {
  const Section wall = Wall(trunk, p.z());
  const Vector3d q(std::abs(p.x()), p.y(), p.z());
  // Most points requested lie far inside of the wall: save them the trigonometry.
  const double u = q.x() / wall.half_width_mm;
  const double v = (q.y() - wall.centre_y_mm) / wall.half_depth_mm;
  constexpr double kFarInside = 0.7, kFarMm = 15.0;
  if (u * u + v * v < kFarInside) return kFarMm;
  const double azimuth = std::clamp(std::atan2(u, v), from, to);
  const Vector3d offset = q - RibPoint(trunk, rib, azimuth);
  const double slope = (RibZ(rib, azimuth + 0.01) - RibZ(rib, azimuth - 0.01)) / 0.02 /
                       std::max(wall.half_width_mm, wall.half_depth_mm);
  const double in_plane = offset.head<2>().norm();
  return EllipsoidDistance(Vector3d(in_plane, offset.z() / std::sqrt(1.0 + slope * slope), 0.0),
                           Vector3d(3.6, 6.2, 1.0));
}

Shape Band(const Trunk& trunk, const Rib& rib, double from, double to) {
  Box bounds;
  for (int i = 0; i <= 40; ++i) {
    const Vector3d point = RibPoint(trunk, rib, from + (to - from) * i / 40.0);
    for (const double side : {-1.0, 1.0}) {
      const Vector3d mirrored(side * point.x(), point.y(), point.z());
      bounds.extend(mirrored - Vector3d::Constant(10.0));
      bounds.extend(mirrored + Vector3d::Constant(10.0));
    }
  }
  return {[=](const Vector3d& p) { return BandDistance(trunk, rib, p, from, to); }, bounds};
}

Shape BothSides(const Shape& right) {
  Box bounds = right.bounds_mm;
  bounds.extend(Vector3d(-bounds.max().x(), bounds.min().y(), bounds.min().z()));
  bounds.extend(Vector3d(-bounds.min().x(), bounds.max().y(), bounds.max().z()));
  return {[inner = right.distance_mm](const Vector3d& p) {
            return inner(Vector3d(std::abs(p.x()), p.y(), p.z()));
          },
          bounds};
}

}  // namespace

void AddRibs(Builder& builder) {
  const Trunk& trunk = builder.trunk;
  for (Rib rib : kRibs) {
    rib.drop *= builder.Vary(std::string("rib ") + rib.name);
    const std::string name = std::string("rib ") + rib.name;
    const Vector3d start = RibPoint(trunk, rib, kStartAzimuth);
    const Vector3d head(19.0, trunk.SpineY(rib.head_z) + 3.0, rib.head_z);
    builder.AddShelled(name, Material::kCancellousBone, Material::kCorticalBone, 1.2,
                       Band(trunk, rib, kStartAzimuth, rib.end_azimuth));
    builder.AddShelled(
        name + " neck", Material::kCancellousBone, Material::kCorticalBone, 1.2,
        BothSides(Tube({head, 0.5 * (head + start) + Vector3d(4, 2, 1), start}, {4.5, 4.5, 4.8})));
    if (rib.cartilage_to > 0.0) {
      builder.Add(name + " cartilage", Material::kCartilage,
                  Band(trunk, rib, rib.end_azimuth, rib.cartilage_to));
    }
  }
}

void AddPelvis(Builder& builder) {
  // The wing: a plate along a bowl that opens upwards, cut off at the crest, in front and behind.
  const double half_thickness = 4.2 * builder.Vary("iliac bone");
  const Shape right{
      [=](const Vector3d& p) {
        const double flare = 0.25 * (p.z() + 60.0);
        const double plate =
            std::abs(SuperellipseDistance(p.x() - 22.0, p.y() + 40.0, 92.0 + flare, 84.0 + flare)) -
            half_thickness;
        const double crest = p.z() + 18.0 + 0.008 * (p.y() + 5.0) * (p.y() + 5.0);
        const double ends = std::max(48.0 - p.x(), -74.0 - p.y());
        return SmoothIntersection(SmoothIntersection(plate, crest, 6.0), ends, 4.0);
      },
      Box(Vector3d(44, -80, -280), Vector3d(136, 66, -14))};
  const Shape bones = BothSides(right);
  builder.AddShelled("iliac bones", Material::kCancellousBone, Material::kCorticalBone,
                     builder.settings.cortical_bone_mm, bones);
  builder.Add("iliacus and gluteus", Material::kMuscle, Grown(bones, 9.0));
}

}  // namespace acus::phantom
