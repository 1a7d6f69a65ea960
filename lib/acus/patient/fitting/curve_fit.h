// Force-depth recordings to the parameters of a puncture, with confidence intervals.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/patient/fitting/curve_phases.h"
#include "acus/patient/fitting/least_squares.h"
#include "acus/physics/forces/laws/force_curve.h"

namespace acus::fitting {

/// A result in the unit of its name. Empty where the recording has no such phase.
struct PunctureCurveFit {
  std::string name;
  bool converged = false;
  std::string message;  ///< Why not, or a remark on the fit.
  CurvePhases phases;
  std::size_t main = 0;   ///< Of phases.punctures: the one that is fitted.
  bool is_entry = false;  ///< It is where the needle comes in from outside: a capsule or skin. Else
                          ///< it is of a structure inside, which says nothing about the capsule.
  bool starts_in_tissue = false;  ///< The force rises at once: the tip was in the tissue already.

  // The rise: F = baseline + slope (d - from) + a1 x + a2 x^2 with x = d - contact > 0.
  std::optional<Estimate> offset_n;          ///< Force at rest before the insertion.
  std::optional<Estimate> contact_depth_mm;  ///< Of the drive.
  std::optional<Estimate> a1_n_per_mm;
  std::optional<Estimate> a2_n_per_mm2;
  std::optional<Estimate> puncture_depth_mm;  ///< Since contact.
  std::optional<Estimate> puncture_n;         ///< a1 x + a2 x^2 at the puncture.
  std::optional<Estimate> drop_n;             ///< From the rise to the plateau line.
  std::optional<Estimate> plateau_n;          ///< Just after the puncture, without offset.
  std::optional<Estimate> plateau_slope_n_per_mm;
  std::optional<Estimate> friction_n_per_mm;  ///< On retraction, + outwards drag per buried mm.
  std::optional<Estimate>
      relaxation_fraction;  ///< Of the force, lost in the hold (its first 10 s).
  std::optional<Estimate> relaxation_time_s;
  std::optional<Estimate> advance_slope_n_per_mm;  ///< Robust line over the whole advance...
  std::optional<double> advance_tip_n;             ///< ...where the advance begins, without offset.
  double advance_travel_mm = 0.0;                  ///< From there to the greatest depth.
  std::optional<double> hold_begin_n;              ///< With which a hold begins, without offset.
  std::optional<double> withdrawal_tip_n;  ///< Pull of the retraction's line where its shaft ends.

  double rise_rms_n = 0.0;
  double plateau_rms_n = 0.0;
  double friction_rms_n = 0.0;
  double relaxation_rms_n = 0.0;

  /// By sample; NaN where no part of the model applies.
  std::vector<double> model_n;

  /// Names and values of all estimates that there are, in a fixed order.
  std::vector<std::pair<std::string, Estimate>> Estimates() const;
};

/// Segments the recording and fits each phase (docs/models/force_fit.md). Deterministic. A needle
/// that comes from outside: its entry, the first fall that is not small beside the largest. Else,
/// or if that has no answer, the puncture with the largest fall that has one.
/// `converged` is false, with the reason in `message`, if there is no puncture, the recording is
/// too short, or the fit of the rise did not converge; the other phases are fitted all the same.
PunctureCurveFit FitPunctureCurve(const ForceCurve& curve);

}  // namespace acus::fitting
