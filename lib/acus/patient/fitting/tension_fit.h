// Tension tests of soft tissue to the parameters of hyperelastic laws.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acus/base/report/svg_plot.h"
#include "acus/patient/fitting/hyperelastic_laws.h"
#include "acus/patient/fitting/least_squares.h"

namespace acus::fitting {

/// One test of a strip pulled along its length.
struct TensionTest {
  std::string name;
  double length_mm = 0.0;  ///< Between the clamps, as mounted.
  double width_mm = 0.0;
  double thickness_mm = 0.0;
  std::vector<double> time_s;
  std::vector<double> elongation_mm;
  std::vector<double> force_n;
};

/// A CSV whose first line is "# length_mm=... width_mm=... thickness_mm=...", then a head with the
/// columns time_s, elongation_mm, force_n. @throws InputError with file and row.
TensionTest ReadTensionTest(const std::filesystem::path& path);

struct LawFit {
  HyperelasticLaw law = HyperelasticLaw::kNeoHookean;
  bool converged = false;
  std::string message;
  std::vector<Estimate> parameters;  ///< As ParametersOf(law), each >= 0.
  Estimate slack_mm;                 ///< Elongation at which the strip is taut.
  double rms_mpa = 0.0;              ///< Of the nominal stress over the loading.
  double relative_rms = 0.0;         ///< The same, of the largest stress that was fitted.
  double aic = 0.0;
};

struct TensionFit {
  bool converged = false;  ///< Any law.
  std::string message;     ///< Why not.
  std::size_t end = 0;     ///< The loading is samples [0, end).
  std::vector<LawFit> laws;
  std::optional<std::size_t> best;  ///< Of laws, by Akaike's criterion.
};

/// Fits every law to the loading: up to where the strip begins to fail, that is where the slope of
/// the force falls below half of its largest, or the force by 5 % of its largest. The slack is
/// fitted with each law; stretch = (length + elongation) / (length + slack). All parameters are >=
/// 0, which keeps the energy convex. Deterministic.
TensionFit FitTension(const TensionTest& test);

nlohmann::json TensionJson(const TensionTest& test, const TensionFit& fit);
report::Plot TensionPlot(const TensionTest& test, const TensionFit& fit);
std::string TensionTable(std::span<const TensionTest> tests, std::span<const TensionFit> fits);

}  // namespace acus::fitting
