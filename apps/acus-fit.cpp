// acus-fit: force-depth recordings to the parameters of a puncture.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "config/json_file.h"
#include "core/atomic_file.h"
#include "core/run_main.h"
#include "fitting/fit_report.h"
#include "report/svg_plot.h"
#include "volume/labels.h"

namespace {

using namespace acus;  // NOLINT: a program may.
namespace fs = std::filesystem;

/// Measured force with the fit over it, and what is left, over `x` (depth or time).
std::vector<report::Plot> Plots(const forces::ForceCurve& curve,
                                const fitting::PunctureCurveFit& fit, const std::vector<double>& x,
                                const char* x_label) {
  report::Series measured{.name = "measured", .x = x, .y = curve.force_n};
  report::Series fitted{.name = "fit", .style = report::Style::kPoints};
  report::Series residual{.name = "measured - fit", .style = report::Style::kPoints};
  for (std::size_t i = 0; i < curve.size(); ++i) {
    if (!std::isfinite(fit.model_n[i])) continue;
    fitted.x.push_back(x[i]);
    fitted.y.push_back(fit.model_n[i]);
    residual.x.push_back(x[i]);
    residual.y.push_back(curve.force_n[i] - fit.model_n[i]);
  }
  report::Plot force{.title = curve.name, .x_label = x_label, .y_label = "force [N]"};
  force.series = {measured, fitted};
  for (const auto& event : fit.phases.punctures) force.marks.push_back({x[event.peak], ""});
  report::Plot rest{.x_label = x_label, .y_label = "residual [N]", .height_px = 180};
  rest.series = {residual};
  return {force, rest};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Fits force-depth recordings: puncture, plateau, friction", "acus-fit");
  std::vector<fs::path> inputs;
  fs::path output;
  std::string tissue;
  double diameter_mm = 1.27;
  app.add_option("CURVES", inputs, "CSV files (time_s,depth_mm,force_n) or two-file recordings")
      ->required()
      ->check(CLI::ExistingPath);
  app.add_option("-o,--output", output, "Folder to make: fit.json, plots as SVG")->required();
  app.add_option("--tissue", tissue, "Also write a force table with this tissue's fitted row");
  app.add_option("--diameter-mm", diameter_mm, "Outer diameter of the needle that was used")
      ->check(CLI::Range(0.2, 5.0))
      ->capture_default_str();
  app.footer("EXAMPLE\n  acus-fit force_curves/*.csv -o fit\n  Then look at fit/fit.svg.");

  return RunMain(app, argc, argv, [&](RunContext& context) {
    if (!tissue.empty()) volume::LabelOf(tissue);
    AtomicFolder folder(output, context.overwrite);
    std::vector<fitting::PunctureCurveFit> fits;
    std::vector<report::Plot> overview;
    nlohmann::json results = nlohmann::json::array();
    std::string failures;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      context.Checkpoint("fitting", static_cast<double>(i) / static_cast<double>(inputs.size()));
      context.provenance.AddInput(inputs[i]);
      const forces::ForceCurve curve = forces::ReadForceCurve(inputs[i]);
      const fitting::PunctureCurveFit& fit = fits.emplace_back(fitting::FitPunctureCurve(curve));
      if (!fit.converged) failures += "\n  " + inputs[i].string() + ": " + fit.message;
      results.push_back(fitting::FitJson(curve, fit));
      const auto by_depth = Plots(curve, fit, curve.depth_mm, "depth [mm]");
      overview.insert(overview.end(), by_depth.begin(), by_depth.end());
      const fs::path plot = folder.path() / (curve.name + "_over_time.svg");
      ACUS_REQUIRE(!fs::exists(plot), inputs[i].string(), ": another curve is named '", curve.name,
                   "' too; rename one");
      report::WriteSvg(plot, Plots(curve, fit, curve.time_s, "time [s]"));
    }
    if (!std::ranges::any_of(fits, &fitting::PunctureCurveFit::converged)) {
      throw NoAnswerError("no curve could be fitted, nothing is written:" + failures);
    }
    config::WriteJson(folder.path() / "fit.json",
                      {{"curves", results}, {"median", fitting::SummaryJson(fits)}});
    report::WriteSvg(folder.path() / "fit.svg", overview);
    if (!tissue.empty()) {
      const auto base = config::ReadJson(config::FindConfig("forces/default.json", "."));
      config::WriteJson(folder.path() / "forces.json",
                        fitting::TableWithFittedTissue(base, tissue, fits, diameter_mm));
    }
    config::WriteJson(folder.path() / "provenance.json", context.provenance.ToJson());
    folder.Commit();
    std::cout << fitting::FitTable(fits);
    if (!failures.empty())
      throw NoAnswerError("the other curves are fitted, but not these:" + failures);
    return ExitCode::kOk;
  });
}
