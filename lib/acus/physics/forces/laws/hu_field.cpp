#include "acus/physics/forces/laws/hu_field.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::forces {
namespace {

constexpr int kMostSteps = 64;

}  // namespace

Eigen::Vector3d HuField::GradientHuPerMm(const Eigen::Vector3d& place,
                                         double reach_mm) const noexcept {
  const double h = std::max(ResolutionMm(), reach_mm);
  Eigen::Vector3d gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(axis);
    gradient[axis] = (HuAt(place + step) - HuAt(place - step)) / (2.0 * h);
  }
  return gradient;
}

double HuField::FirstCrossing(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                              double hu) const noexcept {
  if (HuAt(from) >= hu) return 0.0;
  const Eigen::Vector3d way = to - from;
  const double steps_wanted = std::ceil(way.norm() / (0.5 * ResolutionMm()));
  if (!(steps_wanted >= 1.0)) return 2.0;
  const int steps = static_cast<int>(std::min<double>(steps_wanted, kMostSteps));
  for (int i = 1; i <= steps; ++i) {
    double high = static_cast<double>(i) / steps;
    if (HuAt(from + high * way) < hu) continue;
    double low = static_cast<double>(i - 1) / steps;
    for (int halving = 0; halving < 12; ++halving) {
      const double middle = 0.5 * (low + high);
      (HuAt(from + middle * way) < hu ? low : high) = middle;
    }
    return high;
  }
  return 2.0;
}

CtField::CtField(const volume::CtVolume& ct)
    : ct_(ct),
      index_from_ct_(ct.geometry.index_from_ct()),
      resolution_mm_(ct.geometry.spacing_mm.minCoeff()) {
  ACUS_REQUIRE((ct.geometry.size > 0).all() && ct.voxels.size() == ct.geometry.num_voxels(),
               "the CT has no voxels");
}

double CtField::HuAt(const Eigen::Vector3d& place_in_ct_mm) const noexcept {
  const Eigen::Array3d index = (index_from_ct_ * place_in_ct_mm).array();
  const Eigen::Array3d last = ct_.geometry.size.cast<double>() - 1.0;
  // Written so that NaN fails it.
  if (!((index >= -0.5).all() && (index <= last + 0.5).all())) return kOutsideHu;
  const Eigen::Array3d inside = index.max(0.0).min(last);
  const Eigen::Array3i low = inside.cast<int>();
  const Eigen::Array3i high = (low + 1).min(ct_.geometry.size - 1);
  const Eigen::Array3d f = inside - low.cast<double>();
  const auto row = [&](int j, int k) {
    return ct_.At(low[0], j, k) * (1.0 - f[0]) + ct_.At(high[0], j, k) * f[0];
  };
  const auto plane = [&](int k) { return row(low[1], k) * (1.0 - f[1]) + row(high[1], k) * f[1]; };
  return plane(low[2]) * (1.0 - f[2]) + plane(high[2]) * f[2];
}

}  // namespace acus::forces
