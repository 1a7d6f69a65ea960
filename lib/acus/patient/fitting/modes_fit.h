// One tissue in tension, compression and shear at once, to the parameters of hyperelastic laws.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acus/base/report/svg_plot.h"
#include "acus/patient/fitting/least_squares.h"
#include "acus/physics/mechanics/elements/hyperelastic_law.h"

namespace acus::fitting {

/// How a specimen is loaded. Tension and compression are one test, its stretch above or below 1.
enum class LoadMode { kTension, kCompression, kShear };
inline constexpr LoadMode kLoadModes[] = {LoadMode::kTension, LoadMode::kCompression,
                                          LoadMode::kShear};

/// "tension", "compression", "shear".
std::string_view NameOf(LoadMode mode) noexcept;

/// Nominal stress of an incompressible specimen.
struct ModesTest {
  std::string name;
  std::vector<LoadMode> mode;
  std::vector<double> amount;  ///< Stretch, 1 at rest; or amount of shear, tan of the angle.
  std::vector<double> stress_mpa;

  std::size_t CountOf(LoadMode mode) const;
};

/// A CSV with the columns mode ("axial", "tension", "compression" or "shear"), stretch_or_shear and
/// stress_kpa (or stress_mpa, stress_pa). @throws InputError with file and row; if a stretch or a
/// shear looks like percent; or if there are fewer than 12 rows, or a single mode.
ModesTest ReadModesTest(const std::filesystem::path& path);

/// Nominal stress of an incompressible specimen of a law, MPa: along the load, with free sides; or
/// of simple shear F = I + amount e_x e_z. Fibres lie along the tension, z, between the plates.
double ModeStressMpa(const mechanics::HyperelasticLaw& law, double shear_modulus_mpa, LoadMode mode,
                     double amount) noexcept;

/// A law, with or without fibres, fitted to all modes.
struct ModesLawFit {
  std::string name;  ///< "ogden with 2 exponents and fibres".
  bool converged = false;
  std::string message;  ///< Why not.
  double shear_modulus_mpa = 0.0;
  mechanics::HyperelasticLaw law;
  std::vector<std::string> parameter_names;
  std::vector<Estimate> parameters;
  /// RMS error over the RMS of the measured stress: all rows, and by kLoadModes (0 for a mode that
  /// was not measured).
  double relative_rms = 0.0;
  double relative_rms_of[3] = {0.0, 0.0, 0.0};
  double weighted_rms_mpa = 0.0;  ///< Each mode with the same weight: what is least.
  double independent_rows = 0.0;  ///< What the rows are worth, as their residuals follow another.
  double aic = 0.0;
};

struct ModesFit {
  bool converged = false;  ///< Any law.
  std::string message;     ///< Why not.
  std::vector<ModesLawFit> laws;
  std::optional<std::size_t> best;  ///< Of laws, by Akaike's criterion.
};

/// Fits every law with and without fibres, each mode with the same weight, inside the bounds that
/// keep the energy convex (ogden, fibres) or elliptic (knowles). Deterministic.
ModesFit FitModes(const ModesTest& test);

/// With the block "law" and Young's modulus of a row of an elasticity table for each law.
nlohmann::json ModesJson(const ModesTest& test, const ModesFit& fit);
report::Plot ModesPlot(const ModesTest& test, const ModesFit& fit);
std::string ModesTable(std::span<const ModesTest> tests, std::span<const ModesFit> fits);

}  // namespace acus::fitting
