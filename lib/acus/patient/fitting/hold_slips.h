// Sudden falls of the force while the needle rests, which no relaxation has. A part of
// FitMechanical.
#pragma once

#include <optional>
#include <span>

#include "acus/patient/fitting/shared_fit.h"

namespace acus::fitting {

/// The slip that leaves least of the hold beside `predicted`: with m the prediction and r what is
/// left, after a slip of share q r becomes r + q m, so that q and the gain follow in closed form
/// for every moment. Empty if there is none of 3 % and 0.03 N or more.
/// @param predicted  by sample of samples.all.
std::optional<Slip> BestSlip(const PhaseSamples& samples, const MechanicalModel& model,
                             std::span<const double> predicted);

/// How much more than predicted the strain is lost in the slip after `after_s`, as a share of what
/// the prediction has there; below 0: less. The same closed form, for one moment.
double ShareMissing(const PhaseSamples& samples, const MechanicalModel& model,
                    std::span<const double> predicted, double after_s);

/// Akaike's criterion of the hold, with the number of independent samples of `reference` so that
/// two fits can be compared. @param parameters  that the hold costs.
double HoldCriterion(const PhaseSamples& samples, std::span<const double> predicted,
                     double independent, double parameters);

/// Independent samples of what a prediction leaves of the hold.
double IndependentInHold(const PhaseSamples& samples, std::span<const double> predicted);

}  // namespace acus::fitting
