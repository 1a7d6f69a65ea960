// A whole recording (in, hold, out) to the parameters of the mechanical model.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acus/patient/fitting/curve_fit.h"
#include "acus/patient/fitting/mechanical_model.h"
#include "acus/patient/fitting/puncture_search.h"

namespace acus::fitting {

/// Root mean square by phase; 0 where there is none.
struct PhaseRms {
  double insertion_n = 0.0;
  double hold_n = 0.0;
  double retraction_n = 0.0;
};

struct MechanicalFit {
  bool converged = false;
  std::string message;                ///< Why not.
  std::vector<std::string> warnings;  ///< What the recording does not determine, or hides.
  MechanicalModel constant;           ///< Two constants per direction, no events.
  MechanicalModel eventful;           ///< The same with punctures and releases.
  std::vector<FoundPuncture> punctures;
  std::vector<FoundRelease> releases;
  int relaxing_branches = 0;            ///< 1 to 3, by Akaike's criterion; 0 without a hold.
  std::optional<Estimate> cutting_n;    ///< Insertion less withdrawal, >= 0; needs both phases.
  bool one_friction_is_enough = false;  ///< By Akaike's criterion: the same slope in and out.
  std::vector<std::pair<std::string, Estimate>> estimates;  ///< Of `constant`.
  std::vector<std::string> undetermined;                    ///< Names of estimates.
  PhaseRms line;  ///< Of the best straight line over depth, in and out.
  PhaseRms constant_rms;
  PhaseRms eventful_rms;
};

struct MechanicalOptions {
  bool find_events = true;
};

/// Fits the build-up travels, relaxation and two constants of resistance per direction, then finds
/// internal punctures and releases. `puncture` gives phases, offset and where the tissue begins.
/// Profiles are least squares over their own phase; build-up and relaxation over all phases, each
/// phase with the same weight. Deterministic.
/// Not converged, with a message, if the insertion is shorter than 3 mm or 60 samples.
MechanicalFit FitMechanical(const ForceCurve& curve, const PunctureCurveFit& puncture,
                            const MechanicalOptions& options = {});

/// Drive depth at which the model's depths begin: where the needle begins if it is in the tissue
/// from the start, else where a force is first felt, or the fitted contact before it.
double OriginMm(const ForceCurve& curve, const PunctureCurveFit& puncture);

/// RMS of model - measured, over all samples of each phase.
PhaseRms ReplayRms(const MechanicalModel& model, const ForceCurve& curve,
                   const CurvePhases& phases);

/// The samples from the begin of the insertion to the end of the retraction, replayed.
std::vector<double> ReplayPhases(const MechanicalModel& model, const ForceCurve& curve,
                                 const CurvePhases& phases);

}  // namespace acus::fitting
