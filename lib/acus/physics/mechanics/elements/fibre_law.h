// Fibres that resist being stretched along their direction, as those of muscle do.
#pragma once

#include <Eigen/Core>

#include "acus/physics/mechanics/elements/volume_factor.h"

namespace acus::mechanics {

/// Energy per volume beside that of the isotropic law (Holzapfel, Gasser & Ogden 2000, J. Elast.
/// 61:1-48, one family), with e = max(0, J^(-2/3) |F a|^2 - 1):
///   W = k1 / (2 k2) (exp(k2 e^2) - 1),  k1/2 e^2 where k2 is 0
/// Convex; slack fibres carry nothing. Small strains e_aa > 0 along a meet the additional stress
/// 4 k1 e_aa there. Continued by a parabola where it has stiffened by kLargestStiffening or e is
/// above kLargestX.
struct Fibres {
  double k1_mpa = 0.0;  ///< 0: there are none.
  double k2 = 0.0;
  Eigen::Vector3d direction_in_ct = Eigen::Vector3d::UnitZ();  ///< a; a unit vector.
  bool operator==(const Fibres&) const = default;
};

double FibreEnergyMpa(const Fibres& fibres, const Eigen::Matrix3d& gradient);

/// dW/dF, MPa. Allocates nothing.
Eigen::Matrix3d FibreStressMpa(const Fibres& fibres, const Eigen::Matrix3d& gradient);

/// Second derivative of W by F, MPa.
Matrix9 FibreTangentMpa(const Fibres& fibres, const Eigen::Matrix3d& gradient);

}  // namespace acus::mechanics
