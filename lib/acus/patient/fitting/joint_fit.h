// Several recordings of one tissue at once: what they have in common, and how well it foretells
// another.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "acus/patient/fitting/mechanical_fit.h"

namespace acus::fitting {

/// A recording with its own fit. Only converged ones with insertion, hold and retraction take part.
struct JointRecording {
  const ForceCurve* curve = nullptr;
  const CurvePhases* phases = nullptr;
  const MechanicalFit* fit = nullptr;

  bool IsUsable() const;
};

/// The mechanical model that all share. Its resistance is linear between knots, evenly spaced,
/// whose number is chosen by cross-validation: two knots (two constants per direction) or more,
/// layers of constant friction.
struct JointModel {
  MechanicalModel model;
  int knots_in = 2;
  int knots_out = 2;
};

/// Build-up and relaxation start at the medians of the recordings' and are fitted to all holds and
/// reversals at once (joint_contact.h); the profile is least squares over all,
/// each recording with the same weight. The number of knots, 2 to 60 and 1 mm or more apart, is
/// chosen by how well the recordings are foretold by the others (leave one out, mean of the
/// logarithms of the squares): the finest that is not worse than the best by a paired t-test (95
/// %).
/// @param knots  2 or more holds their number; 0 chooses.
/// @pre at least one usable recording; with fewer than three, two knots.
JointModel FitJoint(std::span<const JointRecording> recordings, int knots = 0);

/// How well a recording is foretold by the others. All RMS over its samples.
struct Prediction {
  std::string name;
  PhaseRms model;       ///< FitJoint of the others, replayed through its motion.
  PhaseRms two_knots;   ///< The same with two constants per direction.
  PhaseRms mean_curve;  ///< The others' pointwise mean: over depth, in the hold over time.
};

/// Leaves each usable recording out in turn; its offset alone is its own. @pre 3 usable or more,
/// else empty.
std::vector<Prediction> LeaveOneOut(std::span<const JointRecording> recordings);

}  // namespace acus::fitting
