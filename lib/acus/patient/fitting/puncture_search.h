// Internal punctures (membranes, vessel walls) during insertion, and releases during withdrawal:
// found one after the other in what a resistance profile leaves, then fitted together.
#pragma once

#include <string>
#include <vector>

#include "acus/patient/fitting/least_squares.h"
#include "acus/patient/fitting/mechanical_model.h"
#include "acus/patient/fitting/profile_fit.h"

namespace acus::fitting {

struct FoundPuncture {
  InternalPuncture law;
  Estimate contact_mm;
  Estimate puncture_mm;  ///< Since contact.
  Estimate peak_n;       ///< a1 x + a2 x^2 at the puncture.
  Estimate step_n;
};

struct FoundRelease {
  Release law;
  Estimate at_mm;
  Estimate step_n;
};

/// How events are distinguished from noise.
struct SearchLimits {
  double least_n = 0.08;  ///< Smaller peaks and steps are not looked at, N.
  int most_events = 16;
};

/// Adds the event that leaves least, and so on; keeps as many as Akaike's criterion is least for
/// (with the number of independent samples, from the autocorrelation of what remains); then fits
/// all with the profile's forces.
/// @param profile  in: its knots; out: its forces beside the events.
std::vector<FoundPuncture> FindInternalPunctures(const StrainedRows& rows,
                                                 const SearchLimits& limits,
                                                 ResistanceProfile& profile);
std::vector<FoundRelease> FindReleases(const StrainedRows& rows, const SearchLimits& limits,
                                       ResistanceProfile& profile);

}  // namespace acus::fitting
