// The phases of a recording around its puncture, each fitted by itself: a part of FitPunctureCurve.
#pragma once

#include "acus/patient/fitting/curve_fit.h"
#include "acus/patient/fitting/curve_models.h"

namespace acus::fitting {

inline constexpr double kStickMm = 4.0;  ///< An embedded needle's shaft slides after this travel.

double OffsetN(const PunctureCurveFit& fit);  ///< 0 where there is no rest to find it from.
/// Drive depth at which a force first appears: during withdrawal the needle leaves the tissue
/// there.
double FirstForceMm(const ForceCurve& curve, const PunctureCurveFit& fit);
Samples RestSamples(const ForceCurve& curve, const CurvePhases& phases);

/// True if the force is higher during withdrawal than during insertion or, without a withdrawal,
/// below its offset deep inside: + must push the needle out.
bool SignIsReversed(const ForceCurve& curve, const PunctureCurveFit& fit);
inline constexpr const char* kReversedSign =
    "the force pulls the needle in while it advances and pushes it out while it is withdrawn; is "
    "its sign reversed? + must push the needle out";

/// Writes a fitted law into fit.model_n at its samples.
void Draw(const ModelFit& law, const SampleModel& model, const Samples& samples,
          PunctureCurveFit& fit);

// Each needs fit.phases, and FitOffset before the others; results go into the members of `fit`.
void FitOffset(const ForceCurve& curve, PunctureCurveFit& fit);
/// The trend of the whole insertion, and whether it began inside the tissue.
void FitAdvance(const ForceCurve& curve, PunctureCurveFit& fit);
void FitRetraction(const ForceCurve& curve, PunctureCurveFit& fit);
void FitHold(const ForceCurve& curve, PunctureCurveFit& fit);

}  // namespace acus::fitting
