// acus-register: landmarks in two spaces to a rigid transform, poses of a pointer to its tip.
#include <CLI/CLI.hpp>
#include <iostream>

#include "core/atomic_file.h"
#include "core/run_main.h"
#include "registration/registration_report.h"
#include "report/residual_plot.h"

namespace {

namespace fs = std::filesystem;
using namespace acus::registration;

struct Options {
  fs::path from, to, target, output;
  std::vector<std::string> leave_out;
  std::optional<double> fle_mm;
  std::vector<fs::path> poses;
  bool robust = false;
};

Landmarks Read(const fs::path& file, acus::RunContext& context) {
  context.provenance.AddInput(file);
  return ReadLandmarks(file);
}

acus::ExitCode RegisterLandmarks(const Options& options, acus::RunContext& context) {
  const auto pairs = Without(MatchLandmarks(Read(options.from, context), Read(options.to, context)),
                             options.leave_out);
  std::optional<Landmarks> targets;
  if (!options.target.empty()) targets = Read(options.target, context);
  RegistrationSettings settings;
  settings.fle_rms_mm = options.fle_mm;
  const RegistrationReport report = Register(pairs, targets, settings);
  for (const std::string& warning : report.warnings) context.Warn(warning);
  const auto plot = acus::report::ResidualPlot("Residuals after registration", pairs.names,
                                               ResidualsMm(report), ErrorsByOthersMm(report));
  acus::AtomicFolder folder(options.output, context.overwrite);
  WriteResult(folder.path(), report, context);
  acus::report::WriteSvg(folder.path() / "residuals.svg", plot);
  folder.Commit();
  std::cout << TableText(report);
  return acus::ExitCode::kOk;
}

acus::ExitCode CalibratePointer(const Options& options, acus::RunContext& context) {
  std::vector<Eigen::Isometry3d> poses;
  for (const fs::path& path : options.poses) {
    context.provenance.AddInput(path);
    for (const Eigen::Isometry3d& pose : ReadPoses(path)) poses.push_back(pose);
  }
  const auto result = options.robust ? CalibratePivotRobustly(poses) : CalibratePivot(poses);
  const auto plot = acus::report::ResidualPlot("Residuals of the poses", {}, result.residual_mm);
  acus::AtomicFolder folder(options.output, context.overwrite);
  WriteResult(folder.path(), result, context);
  acus::report::WriteSvg(folder.path() / "residuals.svg", plot);
  folder.Commit();
  std::cout << TableText(result);
  return acus::ExitCode::kOk;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "Register landmarks rigidly, with the error to expect at a target;\n"
      "or find the tip of a tracked pointer.",
      "acus-register"};
  app.add_option("--from", options.from, "Landmarks in the tracker's or mannequin's frame")
      ->check(CLI::ExistingFile);
  app.add_option("--to", options.to, "The same in CT (.csv, .mrk.json, .fcsv)")
      ->check(CLI::ExistingFile);
  app.add_option("--target", options.target, "Points in CT whose error is asked for")
      ->check(CLI::ExistingFile);
  app.add_option("--fle-mm", options.fle_mm, "Localisation error, RMS; else from the residuals")
      ->check(CLI::Range(1e-6, 1e3));
  app.add_option("--leave-out", options.leave_out, "Landmarks not to use, by name");
  app.add_option("-o,--output", options.output, "Folder to make")->required();
  CLI::App* pivot = app.add_subcommand("pivot", "Find the tip of a pointer turned about it");
  pivot->fallthrough()
      ->add_option("poses", options.poses, "Folders or files of 4 x 4 numbers, or .csv streams")
      ->required()
      ->check(CLI::ExistingPath);
  pivot->add_flag("--robust", options.robust, "Leave out poses that do not fit");
  app.callback([&] {
    const bool has_pairs = !options.from.empty() && !options.to.empty();
    if (!pivot->parsed() && !has_pairs) throw CLI::RequiredError("--from and --to");
  });
  app.footer(
      "EXAMPLE\n"
      "  acus-register --from mannequin.csv --to ct.csv --target target.csv -o registration\n"
      "  acus-register pivot poses -o pointer");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    return (pivot->parsed() ? CalibratePointer : RegisterLandmarks)(options, context);
  });
}
