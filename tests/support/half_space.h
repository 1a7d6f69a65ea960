// Closed solutions of elasticity for forces spread over a small region.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <vector>

#include "acus/physics/mechanics/elements/elasticity_table.h"

namespace acus::testing_support {

struct SmallForce {
  Eigen::Vector3d at_mm;
  Eigen::Vector3d force_n;
};

/// Kelvin 1848: displacement at x by forces inside an infinite body.
inline Eigen::Vector3d KelvinMm(const std::vector<SmallForce>& forces, const Eigen::Vector3d& x,
                                const mechanics::ElasticTissue& tissue) {
  Eigen::Vector3d u = Eigen::Vector3d::Zero();
  const double nu = tissue.poissons_ratio;
  for (const SmallForce& f : forces) {
    const Eigen::Vector3d r = x - f.at_mm;
    const double distance = r.norm();
    u += ((3.0 - 4.0 * nu) * f.force_n + r * r.dot(f.force_n) / (distance * distance)) / distance;
  }
  return u / (16.0 * std::numbers::pi * tissue.ShearModulusMpa() * (1.0 - nu));
}

/// Boussinesq 1885: displacement at x, z <= 0, by forces along z on the surface z = 0 of a body
/// that fills z < 0.
inline Eigen::Vector3d BoussinesqMm(const std::vector<SmallForce>& forces, const Eigen::Vector3d& x,
                                    const mechanics::ElasticTissue& tissue) {
  Eigen::Vector3d u = Eigen::Vector3d::Zero();
  const double nu = tissue.poissons_ratio;
  for (const SmallForce& f : forces) {
    const Eigen::Vector3d r = x - f.at_mm;
    const double distance = r.norm();
    const double depth = -r.z();
    // Into the body, by a force into it; away from the axis.
    const double down = depth * depth / (distance * distance) + 2.0 * (1.0 - nu);
    const double out = depth / (distance * distance) - (1.0 - 2.0 * nu) / (distance + depth);
    u += -f.force_n.z() / distance * Eigen::Vector3d(out * r.x(), out * r.y(), -down);
  }
  return u / (4.0 * std::numbers::pi * tissue.ShearModulusMpa());
}

}  // namespace acus::testing_support
