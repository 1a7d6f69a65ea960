// acus-fit: force-depth recordings to the parameters of a puncture, or to a prediction.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/core/run_main.h"
#include "acus/patient/fitting/fit_task.h"

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  CLI::App app("Fits force-depth recordings: puncture, plateau, friction, whole recordings",
               "acus-fit");
  acus::fitting::FitTask task;
  task.models = {"gaussians", "mechanical"};
  app.add_option("CURVES", task.inputs,
                 "CSV files (time, depth and force with their units) or two-file recordings")
      ->required()
      ->check(CLI::ExistingPath);
  app.add_option("-o,--output", task.output,
                 "Folder to make: fit.json, measured.json (for needle_force.model measured), plots")
      ->required();
  CLI::Option* models =
      app.add_option(
             "--models", task.models,
             "What to fit beside the puncture, joined by commas; hyperelastic, alone, is "
             "for tension tests (CSV with the dimensions in the first line), and so are modes for "
             "one tissue in tension, compression and shear (CSV: "
             "mode,stretch_or_shear,stress_kpa) and indentation for indentations (CSV: "
             "time_s,force_n,indentation_mm,tool_gap_mm)")
          ->delimiter(',')
          ->allow_extra_args(false)
          ->check(CLI::IsMember({"gaussians", "mechanical", "lugre", "hu-table", "hyperelastic",
                                 "modes", "indentation", "all", "none"}))
          ->capture_default_str();
  CLI::Option* tissue = app.add_option("--tissue", task.tissue,
                                       "Also write a force table with this tissue's fitted row");
  app.add_option("--diameter-mm", task.diameter_mm, "Outer diameter of the needle that was used")
      ->check(CLI::Range(0.2, 5.0))
      ->capture_default_str();
  app.add_option("--predict", task.predict,
                 "Fit nothing: predict the curves from this fit of four recordings or more (its "
                 "folder, or its measured.json), with bounds for 95 % of the samples; "
                 "indentations with the shape that those of the fit share")
      ->check(CLI::ExistingPath)
      ->excludes(models)
      ->excludes(tissue);
  app.add_option("--columns", task.columns,
                 "Mapping of a machine's export: which columns are time, depth and force, in which "
                 "units and with which signs (acus-force-columns/1)");
  app.add_flag("--as-it-is", task.as_it_is, "Take forces that no needle takes as they are");
  app.footer("EXAMPLE\n  acus-fit force_curves/*.csv -o fit\n  Then look at fit/fit.svg.");

  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    std::cout << acus::fitting::RunFit(task, context);
    return acus::ExitCode::kOk;
  });
}
