// The bending stiffness of a needle from how far its tip bends.
#pragma once

#include <span>

namespace acus::needle {

/// One measurement of a needle held at its base and pushed across at its tip.
struct TipDeflection {
  double force_n = 0.0;
  double deflection_mm = 0.0;
};

/// The bending stiffness E I, N mm^2, that has the least sum of squared relative differences from
/// the measured deflections; each is that of a clamped rod of this length under a dead load.
/// @throws InputError if there is no measurement, or one is not positive or reaches the length.
double FitBendingStiffness(std::span<const TipDeflection> measured, double length_mm);

/// Tip deflection, across, of a clamped rod under a dead load across at its tip, mm.
double TipDeflectionMm(double force_n, double length_mm, double bending_n_mm2, int num_nodes = 200);

}  // namespace acus::needle
