// Gel between the probe's face and the skin.
#pragma once

#include "acus/imaging/slicing/ct_sampler.h"

namespace acus::ultrasound {

/// Below all fat: neither tissue nor gel.
inline constexpr float kAirBelowHu = -200.0F;

/// Fills air between the face and the skin with the value of the skin, so that the face itself
/// gives no echo. Where the skin is farther than `gap_mm`, the line stays as it is.
void FillCouplingGap(double gap_mm, double step_mm, slicing::BeamImage& hu);

}  // namespace acus::ultrasound
