// Which markers are wrong, when several may be and hide each other.
#pragma once

#include <optional>
#include <vector>

#include "acus/patient/registration/rigid_registration.h"

namespace acus::registration {

struct OutlierSearch {
  std::vector<Eigen::Index> wrong;  ///< Worst first.
  double fre_without_mm = 0.0;      ///< Of the others.
  double p_value = 1.0;  ///< Chance that all markers are good, corrected for the sets looked at.
  /// Markers that might be the wrong ones instead: leaving these out explains the rest about as
  /// well. Empty if the data are clear.
  std::vector<Eigen::Index> instead;
  std::vector<double> error_mm;  ///< Of each marker: its distance from where the good ones put it.
};

/// The largest number of wrong markers that is looked for: the others must be a majority, and at
/// least four, or three of four.
int MostOutliers(Eigen::Index num_markers);

/// Looks at every set of up to MostOutliers() markers. The sets are judged by the sum of squares
/// S_k that remains without the best set of k:
///  - F = ((S_0 - S_k) / 3k) / (S_k / (3 (n - k) - 6)), or (S_0 - S_k) / s^2 by chi-square if the
///    localisation error is known, times the number of sets (Bonferroni), is below `significance`;
///  - taking any one of the k back is as unlikely;
///  - unless the localisation error is known, each of the k is more than 5 times that of the others
///    (RMS, from their residuals) from where they put it: real markers do not all scatter alike.
/// The largest k that passes is taken. Unlike the search one by one it finds markers that hide each
/// other (masking). Beyond 50,000 sets it continues one by one from the best set found.
///
/// @param fle_rms_mm  The localisation error of a marker in both spaces together, if it is known.
OutlierSearch SearchOutliers(const transforms::Markers& reference_mm,
                             const transforms::Markers& ct_mm, std::optional<double> fle_rms_mm,
                             double significance = 0.01);

}  // namespace acus::registration
