// Stiffness of a needle's shaft from its diameters and material.
#pragma once

#include "acus/physics/needle/rod.h"

namespace acus::needle {

/// A slender round tube, or a rod if the inner diameter is 0.
struct Tube {
  double outer_diameter_mm = 0.0;
  double inner_diameter_mm = 0.0;
  double youngs_modulus_mpa = 0.0;
  double poisson_ratio = 0.3;  ///< Steel; G = E / (2 (1 + nu)).

  /// pi (D^4 - d^4) / 64.
  double SecondMomentMm4() const noexcept;
  double BendingStiffnessNMm2() const noexcept;  ///< E I
  double TwistStiffnessNMm2() const noexcept;    ///< G J with J = 2 I
  /// Force per deflection at the end of a cantilever of this length: 3 E I / L^3, N/mm.
  double EndStiffnessNPerMm(double length_mm) const noexcept;
};

/// A straight rod of this tube.
RodProperties RodOf(const Tube& tube, double length_mm);

}  // namespace acus::needle
