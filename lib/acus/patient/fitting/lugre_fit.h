// Recordings to the LuGre friction of Alamilla-2021 eq. 4-6.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "acus/patient/fitting/least_squares.h"
#include "acus/physics/forces/laws/force_curve.h"

namespace acus::fitting {

/// F = offset + (1 + growth (d - middle)) (sigma0 z + sigma1 dz/dt + sigma2 v),
///   dz/dt = v - sigma0 |v| z / g(v),   g(v) = coulomb + (static - coulomb) exp(-|v| / stribeck).
/// Alamilla-2021 eq. 4-6 with the normal force in the constants (they are forces here) and
/// beta = 1 / stribeck; the growth is the shaft that gets buried.
struct LuGreParameters {
  double sigma0_n_per_mm = 1.0;    ///< > 0.
  double sigma1_n_s_per_mm = 0.0;  ///< >= 0.
  double sigma2_n_s_per_mm = 0.0;  ///< >= 0.
  double coulomb_n = 1.0;          ///< > 0.
  double static_n = 1.0;           ///< > 0.
  double stribeck_mm_per_s = 1.0;  ///< > 0.
  double growth_per_mm = 0.0;
  double middle_mm = 0.0;
  double offset_n = 0.0;
};

/// Force at each sample. Exact for constant speed between samples: stable at any speed and step.
std::vector<double> ReplayLuGre(const LuGreParameters& parameters, std::span<const double> time_s,
                                std::span<const double> depth_mm);

struct LuGreFit {
  bool converged = false;
  std::string message;
  std::vector<std::string> warnings;  ///< What the motion cannot determine, and why.
  LuGreParameters parameters;         ///< Undetermined ones at the value that was held or found.
  std::vector<std::pair<std::string, Estimate>> estimates;  ///< Of the free ones.
  std::vector<std::string> undetermined;
  double rms_n = 0.0;  ///< Over the samples in motion.
  double aic = 0.0;
};

/// Least squares from several starts, the best taken. Rests longer than 0.3 s do not count (LuGre
/// does not relax). A recording that moves at one speed does not determine sigma2, the static force
/// and the Stribeck speed: they are held (0, as Coulomb, 1 mm/s), and a warning says so.
LuGreFit FitLuGre(const forces::ForceCurve& curve);

}  // namespace acus::fitting
