#include "acus/patient/phantom/anatomy/trunk.h"

#include <algorithm>
#include <cmath>

namespace acus::phantom {
namespace {

constexpr double kSurfaceStepMm = 0.5;
constexpr double kLowestMm = -160.0;
constexpr double kHighestMm = 300.0;

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
Trunk::Trunk(const BodySettings& settings) {
  const Profile spine_y{{-150, 52}, {-110, 28}, {-85, 15}, {-53, 6},  {-18, 1},  {18, 0.5},
                        {54, 3},    {90, 8},    {121, 13}, {150, 18}, {204, 26}, {253, 30}};
  const Profile half_width{{-120, 153}, {-70, 147}, {0, 134},  {60, 134},
                           {130, 140},  {200, 146}, {260, 148}};
  const Profile front{{-120, -118}, {-40, -128}, {40, -134}, {110, -130}, {180, -115}, {260, -98}};
  const Profile back{{-120, 84}, {-85, 72}, {-53, 66}, {0, 62},
                     {54, 64},   {121, 70}, {178, 76}, {253, 84}};
  const Profile cavity_back{{-120, 55}, {-85, 38}, {-40, 26}, {20, 24},
                            {90, 30},   {121, 38}, {178, 52}, {253, 60}};
  const double fat = settings.subcutaneous_fat_mm;
  for (double z = kLowestMm; z <= kHighestMm; z += kSurfaceStepMm) {
    levels_.push_back({spine_y(z), spine_y.Slope(z),
                       Between(half_width(z) + fat, front(z) - 1.1 * fat, back(z) + 0.8 * fat),
                       Between(half_width(z), front(z), back(z)),
                       Between(half_width(z) - 17.0, front(z) + 10.0, cavity_back(z))});
  }
}

std::pair<std::size_t, double> Trunk::Step(double z_mm) const {
  const double step = (std::clamp(z_mm, kLowestMm, kHighestMm) - kLowestMm) / kSurfaceStepMm;
  const auto i = std::min(static_cast<std::size_t>(step), levels_.size() - 2);
  return {i, step - static_cast<double>(i)};
}

double Trunk::SpineY(double z_mm) const {
  const auto [i, t] = Step(z_mm);
  return (1.0 - t) * levels_[i].spine_y + t * levels_[i + 1].spine_y;
}

double Trunk::SpineSlope(double z_mm) const {
  const auto [i, t] = Step(z_mm);
  return (1.0 - t) * levels_[i].spine_slope + t * levels_[i + 1].spine_slope;
}

Section Trunk::At(double z_mm, Section Level::*layer) const {
  const auto [i, t] = Step(z_mm);
  const Section& a = levels_[i].*layer;
  const Section& b = levels_[i + 1].*layer;
  return {(1.0 - t) * a.half_width_mm + t * b.half_width_mm,
          (1.0 - t) * a.half_depth_mm + t * b.half_depth_mm,
          (1.0 - t) * a.centre_y_mm + t * b.centre_y_mm};
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
