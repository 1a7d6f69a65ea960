// Comparison of two force logs (forces.csv) of the same session.
#pragma once

#include <string>
#include <vector>

#include "acus/assess/regression/comparison/check.h"
#include "acus/assess/regression/comparison/tolerances.h"
#include "acus/base/core/csv.h"

namespace acus::comparison {

/// A force column of both runs at the times that they share, for plots.
struct ForcePair {
  std::string column;
  std::vector<double> a_n;
  std::vector<double> b_n;
};

struct ForceComparison {
  std::vector<Check> checks;
  std::vector<double> time_s;  ///< Times of the samples that both runs have.
  std::vector<ForcePair> forces;
};

/// Compares samples of equal time (column time_s, within the tolerance): each column that ends in
/// `_n` by RMS and largest difference, `depth_mm` by the largest, `tissue` by the share of samples
/// that differ, `event` by names, order and times. Samples and columns that only one run has are
/// failed checks; those of columns are marked `only_in_one`.
/// @param name  Name of the table in the checks.
/// @throws InputError if a table has no time_s, times that do not increase, or a cell in a column
///     to be compared that is not a number.
ForceComparison CompareForces(const CsvTable& a, const CsvTable& b,
                              const ForceTolerances& tolerances,
                              const std::string& name = "force log");

}  // namespace acus::comparison
