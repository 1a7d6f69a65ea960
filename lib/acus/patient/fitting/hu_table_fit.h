// Resistance by Hounsfield units from recordings whose path through a CT is known: Vidal-2008 eq.
// 5-6.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "acus/patient/fitting/curve_phases.h"
#include "acus/patient/fitting/least_squares.h"

namespace acus::fitting {

/// Clamped cubic B-spline: with m breakpoints (rising) there are m + 2 coefficients. Constant
/// beyond the ends; >= 0 where the coefficients are.
struct HuTable {
  std::vector<double> hu;          ///< Breakpoints.
  std::vector<double> n_s_per_mm;  ///< Coefficients: force per speed of the tip.
  double edge_factor = 1.0;        ///< K_edge, where the CT's gradient is above edge_hu_per_mm.
  double edge_hu_per_mm = 40.0;

  double ResistanceNSPerMm(double at_hu) const;
};

struct HuTableFit {
  bool converged = false;
  std::string message;
  std::vector<std::string> warnings;  ///< Ranges of HU that the recordings do not reach.
  HuTable table;
  std::vector<Estimate> n_s_per_mm;  ///< As the coefficients.
  Estimate friction_n_per_mm;        ///< Of the shaft, taken off: force per depth since the start.
  Estimate edge_factor;              ///< Of table.edge_factor; of no width without edges.
  double smoothing = 0.0;            ///< Weight of the coefficients' bends, by cross-validation.
  double rms_n = 0.0;
};

/// Non-negative least squares over the insertions of all recordings that have HU (curve.hu), with a
/// linear term for the shaft that gets buried, and a penalty on bends that is chosen by
/// omitting one recording (of a single one, a fifth of its path) at a time. K_edge is fitted
/// where curve.hu_gradient_per_mm is there. The first 2 mm are omitted: there the force builds up.
/// @param offsets_n  of the sensor, by recording.
HuTableFit FitHuTable(std::span<const ForceCurve> curves, std::span<const CurvePhases> phases,
                      std::span<const double> offsets_n, double edge_hu_per_mm = 40.0);

/// The block "vidal" of a force table (format acus-forces/1).
nlohmann::json VidalBlock(const HuTable& table);

}  // namespace acus::fitting
