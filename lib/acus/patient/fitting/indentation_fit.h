// Indentations of soft tissue, pressed in and held, to a hyperelastic law and a Prony series.
// Equations and assumptions: docs/models/force_fit.md, "Indentation".
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
#include "acus/physics/forces/laws/tissue_time.h"

namespace acus::fitting {

/// One specimen pressed in at one place.
struct IndentationTest {
  std::string name;
  double thickness_mm = 0.0;  ///< Under the tool at first.
  std::vector<double> time_s;
  std::vector<double> depth_mm;
  std::vector<double> force_n;  ///< Less the mean before the tool moves.
};

/// A CSV with the columns time_s, force_n, indentation_mm, tool_gap_mm.
/// @throws InputError with file and row.
IndentationTest ReadIndentationTest(const std::filesystem::path& path);

/// What does not depend on how large the tool is: how the force grows, and how it falls.
struct IndentationShape {
  HyperelasticLaw law = HyperelasticLaw::kNeoHookean;
  std::vector<double> parameters;  ///< As ParametersOf(law), the first one 1.
  forces::ForceRelaxation relaxation;
};

/// Force of a column of thickness - contact under a tool of unit area and stiffness:
///   F = G * dS/dt (a convolution),  S = -2 (lambda - lambda^-2) dW/dI1,
///   lambda = (thickness - depth) / (thickness - contact),  G = 1 - sum share (1 - exp(-t / time)).
/// Exact where S is linear in time between two samples.
std::vector<double> ReplayIndentation(const IndentationShape& shape, const IndentationTest& test,
                                      double contact_mm);

/// One specimen with one law. The stiffness is area times the law's first parameter.
struct IndentationFit {
  bool converged = false;
  std::string message;  ///< Why not.
  IndentationShape shape;
  Estimate contact_mm;  ///< Depth at which the tool meets the tissue.
  double stiffness_n = 0.0;
  double relative_rms = 0.0;       ///< Of the largest force, over all samples.
  double relative_rms_hold = 0.0;  ///< The same in the hold.
  double aic = 0.0;
};

/// The law with the least Akaike criterion, with three terms of relaxation. Deterministic.
IndentationFit FitIndentation(const IndentationTest& test);

/// One shape for several specimens, each with its own contact and stiffness: every specimen with
/// the same weight. @pre at least one fit converged.
IndentationShape FitSharedShape(std::span<const IndentationTest> tests,
                                std::span<const IndentationFit> fits);

/// Contact and stiffness alone, with a given shape.
IndentationFit FitWithShape(const IndentationTest& test, const IndentationShape& shape);

nlohmann::json ShapeJson(const IndentationShape& shape);
/// @throws InputError beginning with `label`.
IndentationShape ShapeFromJson(const nlohmann::json& document, const std::string& label);
nlohmann::json IndentationJson(const IndentationTest& test, const IndentationFit& fit);
report::Plot IndentationPlot(const IndentationTest& test, const IndentationFit& fit);
std::string IndentationTable(std::span<const IndentationTest> tests,
                             std::span<const IndentationFit> fits);

}  // namespace acus::fitting
