#include "acus/patient/phantom/planning/rib_shadow.h"

#include <cmath>
#include <map>

#include "acus/base/math/angles.h"
#include "acus/data/volume/labels.h"

namespace acus::phantom {

using Eigen::Vector3d;

RibShadow::RibShadow(const PatientField& field, const Vector3d& point, const Vector3d& normal) {
  constexpr double kDepthMm = 45.0;
  constexpr int kDirections = 36;
  static const volume::Label kBone = volume::LabelOf("bone");
  static const volume::Label kCartilage = volume::LabelOf("cartilage");  // Ribs end in it in front.
  u_ = normal.unitOrthogonal();
  v_ = normal.cross(u_);
  for (int n = 0; n < kSize * kSize; ++n) {
    const Vector3d start = point + kStepMm * ((n % kSize - kHalf) * u_ + (n / kSize - kHalf) * v_);
    // From a little outside: the chest is round, its skin falls back from the tangent plane.
    for (double depth = -10.0; depth <= kDepthMm && !bone_[n]; depth += 2.0) {
      const volume::Label label = field.LabelAt(start - depth * normal);
      bone_[n] = label == kBone || label == kCartilage;
    }
  }
  double sharpest = -1.0;
  for (int n = 0; n < kDirections; ++n) {
    const double angle = n * 180.0 / kDirections * math::kRadPerDegree;
    const double sharpness = Sharpness(angle);
    if (sharpness <= sharpest) continue;
    sharpest = sharpness;
    rib_angle_rad_ = angle;
  }
}

double RibShadow::Sharpness(double angle_rad) const {
  std::map<int, double> line;
  for (int n = 0; n < kSize * kSize; ++n) {
    const int i = n % kSize - kHalf;
    const int j = n / kSize - kHalf;
    if (!bone_[n] || std::hypot(i, j) > kHalf) continue;  // A disc: corners favour diagonals.
    line[static_cast<int>(std::lround(j * std::cos(angle_rad) - i * std::sin(angle_rad)))] += 1.0;
  }
  double sum = 0.0;
  for (const auto& [across, count] : line) sum += count * count;
  return sum;
}

bool RibShadow::At(double u_mm, double v_mm) const {
  const auto i = static_cast<int>(std::lround(u_mm / kStepMm)) + kHalf;
  const auto j = static_cast<int>(std::lround(v_mm / kStepMm)) + kHalf;
  return i >= 0 && j >= 0 && i < kSize && j < kSize && bone_[j * kSize + i];
}

bool RibShadow::IsBetweenRibs() const {
  constexpr double kReachMm = 36.0;
  if (At(0.0, 0.0)) return false;
  for (const double side : {1.0, -1.0}) {
    bool has_rib = false;
    for (double across = kStepMm; across <= kReachMm && !has_rib; across += kStepMm)
      has_rib =
          At(-side * across * std::sin(rib_angle_rad_), side * across * std::cos(rib_angle_rad_));
    if (!has_rib) return false;
  }
  return true;
}

Vector3d RibShadow::rib_direction() const {
  return std::cos(rib_angle_rad_) * u_ + std::sin(rib_angle_rad_) * v_;
}

}  // namespace acus::phantom
