// Aorta, vena cava, iliac vessels, portal and hepatic veins; bowel and stomach with gas.
#include <algorithm>
#include <cmath>

#include "acus/patient/phantom/anatomy/trunk.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

void AddBowelPart(Builder& builder, const std::string& name, Material wall_and_content,
                  const Shape& shape, double wall_mm, double gas_level_y_mm) {
  // The patient lies on the back: gas rises to the front, down to a flat level.
  builder.Add(name + " gas", Material::kGas,
              {[inner = shape.distance_mm, wall_mm, gas_level_y_mm](const Vector3d& p) {
                 return std::max(inner(p) + wall_mm, p.y() - gas_level_y_mm);
               },
               shape.bounds_mm});
  builder.Add(name, wall_and_content, shape);
}

}  // namespace

void AddBileDucts(Builder& builder) {
  const double radius = 0.5 * builder.settings.bile_duct_mm;
  if (radius <= 0.0) return;
  // In front of the branches of the portal vein, thinner towards the periphery.
  builder.Add("right bile duct", Material::kGallbladder,
              Tube({{-30, -78, 116}, {-46, -70, 142}, {-72, -54, 147}, {-98, -46, 162}},
                   {radius, radius, 0.9 * radius, 0.5 * radius}));
  builder.Add("left bile duct", Material::kGallbladder,
              Tube({{-42, -72, 140}, {-20, -93, 156}, {14, -100, 166}},
                   {radius, 0.9 * radius, 0.5 * radius}));
  builder.landmarks["bile_duct"] = Vector3d(-72, -54, 147);
}

void AddVessels(Builder& builder) {
  const Trunk& trunk = builder.trunk;
  const auto before_spine = [&trunk](double x, double gap, double z) {
    return Vector3d(x, trunk.SpineY(z) - 34.0 - gap, z);
  };
  const double aorta = 9.5 * builder.Vary("aorta");
  const double cava = 11.0 * builder.Vary("vena cava");
  builder.Add("aorta", Material::kVessel,
              Tube({before_spine(16, 8, 262), before_spine(12, 10, 190), before_spine(8, 12, 120),
                    before_spine(8, 12, 50), before_spine(6, 12, -14)},
                   {aorta + 2, aorta + 1, aorta, aorta - 0.5, aorta - 1}));
  builder.Add("vena cava", Material::kVessel,
              Tube({Vector3d(-22, -48, 212), Vector3d(-24, -44, 170), before_spine(-23, 9, 110),
                    before_spine(-20, 9, 40), before_spine(-17, 9, -24)},
                   {cava + 2, cava + 1, cava, cava, cava - 1}));
  for (const double side : {-1.0, 1.0}) {
    builder.Add("iliac artery", Material::kVessel,
                Tube({before_spine(6, 12, -14), before_spine(side * 26, 12, -62),
                      Vector3d(side * 48, -34, -125)},
                     {6.5, 5.5, 5}));
    builder.Add("iliac vein", Material::kVessel,
                Tube({before_spine(-17, 9, -24), before_spine(side * 24 - 5, 2, -64),
                      Vector3d(side * 44, -18, -125)},
                     {8, 7, 6.5}));
    builder.Add("renal vein", Material::kVessel,
                Tube({before_spine(side < 0 ? -20 : -12, 10, 72), Vector3d(side * 34, -26, 72),
                      Vector3d(side * 48, 0, 70)},
                     {5, 4.5, 4}));
  }
  builder.Add(
      "portal vein", Material::kVessel,
      Tube({{8, -66, 100}, {-22, -68, 124}, {-42, -58, 138}, {-70, -42, 142}, {-92, -32, 158}},
           {6.5, 7, 6, 4.5, 2.5}));
  builder.Add("left portal vein", Material::kVessel,
              Tube({{-38, -60, 137}, {-22, -82, 152}, {12, -88, 162}}, {5, 4, 2.5}));
  builder.Add("right hepatic vein", Material::kVessel,
              Tube({{-26, -46, 200}, {-58, -38, 186}, {-86, -34, 160}, {-102, -34, 126}},
                   {5.5, 4.5, 3.5, 2}));
  builder.Add("middle hepatic vein", Material::kVessel,
              Tube({{-24, -50, 200}, {-38, -70, 182}, {-52, -88, 152}}, {5, 4, 2.5}));
  builder.Add("left hepatic vein", Material::kVessel,
              Tube({{-20, -52, 200}, {6, -72, 190}, {30, -84, 180}}, {4.5, 3.5, 2.5}));
}

void AddBowel(Builder& builder) {
  AddBowelPart(builder, "stomach", Material::kStomach,
               Ellipsoid(Vector3d(58, -68, 152), builder.Vary("stomach") * Vector3d(36, 30, 50),
                         Eigen::AngleAxisd(0.5, Vector3d::UnitY()).toRotationMatrix()),
               4.0, -84.0);
  AddBowelPart(
      builder, "ascending colon", Material::kBowel,
      Tube({{-62, -58, -95}, {-78, -36, -45}, {-92, -26, 5}, {-86, -48, 40}}, {24, 24, 22, 20}),
      2.5, -38.0);
  AddBowelPart(
      builder, "transverse colon", Material::kBowel,
      Tube({{-80, -74, 44}, {-40, -100, 34}, {10, -104, 36}, {60, -96, 62}, {96, -40, 102}},
           {17, 17, 17, 17, 16}),
      2.5, -103.0);
  AddBowelPart(
      builder, "descending colon", Material::kBowel,
      Tube({{98, -38, 100}, {102, -18, 40}, {94, -20, -10}, {74, -46, -55}, {62, -66, -100}},
           {15, 14, 14, 14, 14}),
      2.5, -30.0);
  // Small bowel: two sheets of loops that fill the middle of the abdomen.
  RandomStream random(builder.seed, "small bowel");
  for (int row = 0; row < 12; ++row) {
    const bool behind = row % 2 == 1;
    std::vector<Vector3d> points;
    std::vector<double> radii;
    for (int i = 0; i < 6; ++i) {
      points.emplace_back(
          -62.0 + 25.0 * i + random.Uniform(-7, 7),
          (behind ? -66.0 : -100.0) + 7.0 * ((i + row / 2) % 2) + random.Uniform(-6, 6),
          18.0 - 13.5 * row + random.Uniform(-6, 6));
      radii.push_back(random.Uniform(10.5, 14.0));
    }
    const double level = row % 4 == 0 ? -103.0 : -200.0;  // Some of the front loops hold gas.
    AddBowelPart(builder, "small bowel " + std::to_string(row + 1), Material::kBowel,
                 Tube(points, radii), 2.0, level);
  }
}

}  // namespace acus::phantom
