#include "phantom/trunk.h"

#include <algorithm>
#include <cmath>

namespace acus::phantom {
namespace {

/// The back is hollow along the midline: there the surface lies this much deeper.
double Furrow(double x_mm, double y_mm, double centre_y_mm, double depth_mm) {
  if (y_mm <= centre_y_mm) return 0.0;
  const double back = std::min((y_mm - centre_y_mm) / 40.0, 1.0);
  return depth_mm * back * back * std::exp(-x_mm * x_mm / (16.0 * 16.0));
}

double LayerDistance(const Eigen::Vector3d& p, const Section& s, double furrow_mm) {
  const double y = p.y() + Furrow(p.x(), p.y(), s.centre_y_mm, furrow_mm);
  return SuperellipseDistance(p.x(), y - s.centre_y_mm, s.half_width_mm, s.half_depth_mm);
}

Section Between(double half_width_mm, double front_y_mm, double back_y_mm) {
  return {half_width_mm, 0.5 * (back_y_mm - front_y_mm), 0.5 * (back_y_mm + front_y_mm)};
}

}  // namespace

// Heights as in AddSpine: L5 at -53, L3 at 18, T12 at 121, T8 at 229.
Trunk::Trunk(const BodySettings& settings)
    : fat_mm_(settings.subcutaneous_fat_mm),
      spine_y_{{-150, 52}, {-110, 28}, {-85, 15}, {-53, 6},  {-18, 1},  {18, 0.5},
               {54, 3},    {90, 8},    {121, 13}, {150, 18}, {204, 26}, {253, 30}},
      half_width_{{-120, 168}, {-70, 162}, {0, 149}, {60, 149}, {130, 155}, {200, 161}, {260, 163}},
      front_{{-120, -118}, {-40, -128}, {40, -134}, {110, -130}, {180, -115}, {260, -98}},
      back_{{-120, 92}, {-85, 80}, {-53, 74}, {0, 70}, {54, 72}, {121, 78}, {178, 84}, {253, 92}},
      cavity_back_{{-120, 55}, {-85, 38}, {-40, 26}, {20, 24},
                   {90, 30},   {121, 38}, {178, 52}, {253, 60}} {}

Section Trunk::Skin(double z_mm) const {
  const Section inner = Fascia(z_mm);
  return Between(inner.half_width_mm + fat_mm_,
                 inner.centre_y_mm - inner.half_depth_mm - 1.1 * fat_mm_,
                 inner.centre_y_mm + inner.half_depth_mm + 0.8 * fat_mm_);
}

Section Trunk::Fascia(double z_mm) const {
  return Between(half_width_(z_mm) - 15.0, front_(z_mm), back_(z_mm) - 8.0);
}

Section Trunk::Cavity(double z_mm) const {
  return Between(half_width_(z_mm) - 32.0, front_(z_mm) + 10.0, cavity_back_(z_mm));
}

double Trunk::SkinDistance(const Eigen::Vector3d& p) const {
  return LayerDistance(p, Skin(p.z()), 5.0);
}

double Trunk::FasciaDistance(const Eigen::Vector3d& p) const {
  return LayerDistance(p, Fascia(p.z()), 4.0);
}

double Trunk::CavityDistance(const Eigen::Vector3d& p) const {
  return LayerDistance(p, Cavity(p.z()), 0.0);
}

double DiaphragmZ(double x_mm, double y_mm) {
  const auto dome = [&](double x0, double y0, double rx, double ry, double top, double fall) {
    const double u = (x_mm - x0) / rx;
    const double v = (y_mm - y0) / ry;
    return top - fall * std::min(u * u + v * v, 2.0);
  };
  const double right = dome(-66, -38, 68, 88, 214, 92);
  const double left = dome(66, -34, 66, 86, 203, 88);
  const double middle = dome(2, -60, 62, 80, 186, 60);  // Under the heart.
  return -SmoothUnion(SmoothUnion(-right, -left, 15.0), -middle, 15.0);
}

}  // namespace acus::phantom
