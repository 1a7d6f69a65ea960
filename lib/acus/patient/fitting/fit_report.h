// Fits as JSON, as a table for the terminal, and as a row of a force table.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "acus/patient/fitting/curve_fit.h"

namespace acus::fitting {

/// One fit: estimates with 95 % intervals (alone, and for all parameters at once), phases,
/// punctures, residuals by phase, and why there is no answer if there is none.
nlohmann::json FitJson(const ForceCurve& curve, const PunctureCurveFit& fit);

/// Median, quartiles and number of each parameter over several fits: all count that have it.
nlohmann::json SummaryJson(std::span<const PunctureCurveFit> fits);

/// A line per fit, aligned, with units in the head.
std::string FitTable(std::span<const PunctureCurveFit> fits);

/// `base` (a document of the format acus-forces/1) with the row of `tissue` replaced by the medians
/// of the usable fits, scaled from the needle that was measured to the table's reference needle.
/// Cutting and friction of the insertion are those of the line of the whole advance if most needles
/// are in the tissue from the start; else friction is the slope of the plateau, and
///   cutting = plateau - friction x shaft in the tissue at the puncture, not below 0.
/// a1, a2 and puncture_n are the capsule's, from recordings in which the needle comes in from
/// outside (is_entry); without one they are those of the largest puncture inside each recording.
/// no_membrane_from, friction_rate and friction_dwell stay what they are in `base`.
/// @param relaxation  array of the row, see fitted_relaxation.h.
/// @throws NoAnswerError if no fit has the plateau or none the friction, or these are not a row
///     that a table may have.
nlohmann::json TableWithFittedTissue(nlohmann::json base, const std::string& tissue,
                                     std::span<const PunctureCurveFit> fits,
                                     const nlohmann::json& relaxation, double measured_diameter_mm);

}  // namespace acus::fitting
