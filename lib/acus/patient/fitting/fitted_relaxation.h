// How the force falls in the holds of recordings, as a row of a force table has it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <vector>

#include "acus/patient/fitting/curve_fit.h"
#include "acus/physics/forces/laws/tissue_time.h"

namespace acus::fitting {

/// What remains of the force that a hold begins with.
struct HoldCurve {
  std::vector<double> held_s;  ///< Increasing.
  std::vector<double> left;    ///< 1 at first.

  /// The mean of several holds, at times spaced by their logarithm, as long as half of them last.
  /// Each fit is of the curve at the same place. Empty if no hold lasts a second.
  static HoldCurve MeanOf(std::span<const ForceCurve* const> curves,
                          std::span<const PunctureCurveFit> fits);
};

/// 1 - sum_k share_k (1 - exp(-t / time_k)) by least squares: one to three terms, by Akaike's
/// criterion. No terms if the curve is empty or no series follows it.
forces::ForceRelaxation FitHold(const HoldCurve& curve);

/// The same as the array "relaxation" of a row: at most 0.95 together, of times that a table takes.
nlohmann::json RelaxationRow(const forces::ForceRelaxation& hold);

}  // namespace acus::fitting
