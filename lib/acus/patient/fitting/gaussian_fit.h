// A sum of Gaussians over the depth: Vidal-2008 fig. 5 describes a whole insertion by eight of
// them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "acus/patient/fitting/curve_phases.h"
#include "acus/patient/fitting/least_squares.h"

namespace acus::fitting {

/// height exp(-((depth - centre) / width)^2).
struct Gaussian {
  double height_n = 0.0;
  double centre_mm = 0.0;
  double width_mm = 1.0;  ///< > 0.
};

double SumN(std::span<const Gaussian> terms, double depth_mm);

struct GaussianFit {
  bool converged = false;
  std::string message;
  std::vector<Gaussian> terms;     ///< By centre.
  std::vector<Estimate> height_n;  ///< As terms; empty if the terms cannot be distinguished.
  std::vector<Estimate> centre_mm;
  std::vector<Estimate> width_mm;
  double rms_n = 0.0;  ///< Over all samples of the insertion.
  double aic = 0.0;
};

/// Fits `count` terms to the insertion (all samples of phases.advance).
///
/// The start is found greedily: of a grid of centres and widths the term that leaves least is
/// added, all terms are fitted, and so on; then each term in turn is taken out and looked for
/// again, as long as that helps. No random numbers: the same curve gives the same bits. Not
/// converged (with a message) where the insertion is shorter than 1 mm or 4 samples per term. Where
/// `count` terms leave more than kEnoughN (an insertion past many structures), further terms are
/// added in the same way, up to `most`.
/// @pre count in [1, 32].
inline constexpr double kEnoughN = 0.045;
GaussianFit FitGaussians(const ForceCurve& curve, const CurvePhases& phases, int count = 8,
                         int most = 0);

}  // namespace acus::fitting
