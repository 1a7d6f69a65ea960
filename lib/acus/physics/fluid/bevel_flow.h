// Flow from the bevel into the tissues at its opening, as a function of the pressure there.
//
//   q = (p - p_tissue - p_open) / B   above p_tissue + p_open
//   q = 0                             between
//   q = (p - p_tissue) / B            below p_tissue, at most what can return
//
// Continuous and monotone for each tissue, and so for their sum.
#pragma once

#include <array>
#include <cstddef>

namespace acus::fluid {

struct BevelBranch {
  double tissue_kpa = 0.0;
  double opening_kpa = 0.0;     ///< >= 0.
  double kpa_s_per_ml = 0.0;    ///< B > 0; 0: the branch is closed.
  double least_ml_per_s = 0.0;  ///< <= 0: the fastest return.
};

struct BevelFlow {
  double ml_per_s = 0.0;            ///< Sum, + into the tissue.
  double slope_ml_per_kpa_s = 0.0;  ///< Its derivative by the pressure; >= 0.
  std::array<double, 2> branch_ml_per_s = {};
};

struct BevelLaw {
  std::array<BevelBranch, 2> branch;

  BevelFlow FlowAt(double kpa) const noexcept {
    BevelFlow out;
    for (std::size_t i = 0; i < branch.size(); ++i) {
      const BevelBranch& b = branch[i];
      if (b.kpa_s_per_ml <= 0.0) continue;
      const double above_kpa = kpa - b.tissue_kpa;
      double excess_kpa = 0.0;
      if (above_kpa > b.opening_kpa) {
        excess_kpa = above_kpa - b.opening_kpa;
      } else if (above_kpa < 0.0) {
        excess_kpa = above_kpa;
      } else {
        continue;
      }
      double flow = excess_kpa / b.kpa_s_per_ml;
      if (flow > b.least_ml_per_s) {
        out.slope_ml_per_kpa_s += 1.0 / b.kpa_s_per_ml;
      } else {
        flow = b.least_ml_per_s;
      }
      out.branch_ml_per_s[i] = flow;
      out.ml_per_s += flow;
    }
    return out;
  }
};

}  // namespace acus::fluid
