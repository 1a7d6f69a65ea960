// Displacements of more nodes than the compliance holds. Private to this module.
#pragma once

#include <span>
#include <vector>

#include "acus/physics/mechanics/condensation/condensed_factor.h"

namespace acus::mechanics {

/// With the rows R of a CondensedFactor and all others I, a force on R moves
///     u_I = -L11^-T L21^T C f:
/// only the backward half of a solve, and of it only the columns that the required nodes depend on
/// (their ancestors in the elimination tree).
class BackSubstitution {
 public:
  /// @param wanted  Rows of free nodes, may be among those of R. `factor` must live longer.
  BackSubstitution(const CondensedFactor& factor, std::span<const int> wanted);

  /// Displacements, mm/N, of the required nodes (3 each) by unit forces on rows first ..
  /// first + count of the compliance: one column of 3 required.size() values after the other.
  void Columns(int first, int count, float* out);

 private:
  void SolveGroup(int group, int count);

  const CondensedFactor& factor_;
  Supernodes groups_;
  int num_condensed_ = 0;         ///< Rows of R.
  std::vector<char> is_needed_;   ///< By group.
  std::vector<long> place_;       ///< Of each row in the order of elimination, in solution_; -1.
  std::vector<long> wanted_;      ///< Place of each required row.
  std::vector<double> solution_;  ///< `count` values for each place.
  std::vector<double> gathered_;
};

}  // namespace acus::mechanics
