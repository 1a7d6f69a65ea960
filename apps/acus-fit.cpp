// acus-fit: force-depth recordings to the parameters of a puncture.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/run_main.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/fitting/fit_models.h"
#include "acus/patient/fitting/fit_report.h"

namespace {

using namespace acus;  // NOLINT: a program may.
namespace fs = std::filesystem;

/// Writes a curve's pictures into `folder`.
void WritePlots(const fs::path& folder, const fitting::FittedCurve& fitted) {
  const std::string& name = fitted.curve.name;
  report::WriteSvg(folder / (name + "_over_time.svg"),
                   fitting::PuncturePlots(fitted, fitted.curve.time_s, "time [s]"));
  if (!fitted.gaussians && !fitted.mechanical && !fitted.lugre) return;
  report::WriteSvg(folder / (name + "_models.svg"), fitting::DepthPlots(fitted));
  report::WriteSvg(folder / (name + "_replay.svg"), fitting::TimePlots(fitted));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Fits force-depth recordings: puncture, plateau, friction, whole recordings",
               "acus-fit");
  std::vector<fs::path> inputs;
  fs::path output;
  std::string tissue;
  std::vector<std::string> model_names = {"gaussians", "mechanical"};
  double diameter_mm = 1.27;
  app.add_option("CURVES", inputs, "CSV files (time_s,depth_mm,force_n) or two-file recordings")
      ->required()
      ->check(CLI::ExistingPath);
  app.add_option("-o,--output", output, "Folder to make: fit.json, plots as SVG")->required();
  app.add_option("--models", model_names, "What to fit beside the puncture, joined by commas")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"gaussians", "mechanical", "lugre", "hu-table", "all", "none"}))
      ->capture_default_str();
  app.add_option("--tissue", tissue, "Also write a force table with this tissue's fitted row");
  app.add_option("--diameter-mm", diameter_mm, "Outer diameter of the needle that was used")
      ->check(CLI::Range(0.2, 5.0))
      ->capture_default_str();
  app.footer("EXAMPLE\n  acus-fit force_curves/*.csv -o fit\n  Then look at fit/fit.svg.");

  return RunMain(app, argc, argv, [&](RunContext& context) {
    if (!tissue.empty()) volume::LabelOf(tissue);
    const auto models = fitting::FitModels::FromNames(model_names);
    AtomicFolder folder(output, context.overwrite);
    std::vector<fitting::FittedCurve> fits;
    std::vector<fitting::PunctureCurveFit> punctures;
    std::vector<report::Plot> overview;
    nlohmann::json results = nlohmann::json::array();
    std::string failures;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      context.Checkpoint("fitting", static_cast<double>(i) / static_cast<double>(inputs.size()));
      context.provenance.AddInput(inputs[i]);
      const fitting::FittedCurve& fit =
          fits.emplace_back(fitting::FitModelsTo(forces::ReadForceCurve(inputs[i]), models));
      punctures.push_back(fit.puncture);
      if (!fit.puncture.converged) {
        failures += "\n  " + inputs[i].string() + ": " + fit.puncture.message;
      }
      results.push_back(fitting::CurveJson(fit));
      const auto plots = fitting::PuncturePlots(fit, fit.curve.depth_mm, "depth [mm]");
      overview.insert(overview.end(), plots.begin(), plots.end());
      ACUS_REQUIRE(!fs::exists(folder.path() / (fit.curve.name + "_over_time.svg")),
                   inputs[i].string(), ": another curve is named '", fit.curve.name,
                   "' too; rename one");
      WritePlots(folder.path(), fit);
    }
    if (!std::ranges::any_of(punctures, &fitting::PunctureCurveFit::converged)) {
      throw NoAnswerError("no curve could be fitted, nothing is written:" + failures);
    }
    nlohmann::json document = fitting::TogetherJson(fits, models);
    document["curves"] = results;
    config::WriteJson(folder.path() / "fit.json", document);
    report::WriteSvg(folder.path() / "fit.svg", overview);
    if (!tissue.empty()) {
      const auto base = config::ReadJson(config::FindConfig("forces/default.json", "."));
      config::WriteJson(folder.path() / "forces.json",
                        fitting::TableWithFittedTissue(base, tissue, punctures, diameter_mm));
    }
    config::WriteJson(folder.path() / "provenance.json", context.provenance.ToJson());
    folder.Commit();
    std::cout << fitting::FitTable(punctures) << fitting::ModelTable(fits);
    if (!failures.empty())
      throw NoAnswerError("the other curves are fitted, but not these:" + failures);
    return ExitCode::kOk;
  });
}
