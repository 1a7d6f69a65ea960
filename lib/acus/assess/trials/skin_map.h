// The skin around a trial's entry, with the entries of alternatives coloured by their scores.
#pragma once

#include <string>

#include "acus/assess/trials/what_if.h"

namespace acus::trials {

/// An SVG image, in the plane of the skin at the trial's entry, seen from outside: a disc per
/// alternative, the best on top, its colour from the worst score of all (dark) to the best (light);
/// a ring for the trial, a cross for the point of the skin above the target, a line for the probe's
/// face. Axes are those of the patient. Each disc names its change and outcome in its <title>.
std::string SkinMapSvg(const TrialScene& scene, const session::Session& trial,
                       const WhatIf& what_if);

}  // namespace acus::trials
