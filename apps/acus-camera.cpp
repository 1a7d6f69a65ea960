// acus-camera: print boards and facets, calibrate and place cameras, track facets in images.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/run_main.h"
#include "acus/rig/camera/calibration.h"
#include "acus/rig/camera/facet_tasks.h"
#include "acus/rig/camera/rig_tasks.h"
#include "acus/rig/camera/sheet.h"

namespace {

namespace fs = std::filesystem;
using namespace acus::camera;

struct Options {
  fs::path board = "cameras/board_a4.json", facets = "facets/training.json", images, output;
  fs::path camera = "cameras/webcam_720p.json";
  CalibrationSettings calibration;
};

fs::path Find(const fs::path& name, acus::RunContext& context) {
  const fs::path path = acus::config::FindConfig(name, fs::current_path());
  context.provenance.AddInput(path);
  return path;
}

void Print(const Options& o, const fs::path& folder, acus::RunContext& context) {
  WriteSheets(folder, "board", {BoardSheet(ReadBoard(Find(o.board, context)))});
  WriteSheets(folder, "facets", FacetSheets(ReadFacets(Find(o.facets, context))));
  acus::config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
}

void Calibrate(const Options& o, const fs::path& folder, acus::RunContext& context) {
  const auto result = CalibrateCamera(ImageFiles(o.images), ReadBoard(Find(o.board, context)),
                                      o.calibration, context);
  for (const std::string& warning : result.warnings) context.Warn(warning);
  WriteResult(folder, result, context);
  std::cout << TableText(result);
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App app{"Prepare an ordinary camera as a tracker and for the overlay.", "acus-camera"};
  app.require_subcommand(1);
  app.add_option("-o,--output", o.output, "Folder to make")->required();
  app.add_option("--board", o.board, "Calibration board")->capture_default_str();
  app.add_option("--facets", o.facets, "Facets on mannequin and tools")->capture_default_str();
  app.add_option("--camera", o.camera, "Camera file")->capture_default_str();
  auto* print = app.add_subcommand("print", "Sheets at true scale: PDF, SVG, PNG")->fallthrough();
  auto* calibrate = app.add_subcommand("calibrate", "Images of the board to a camera file");
  calibrate->fallthrough()
      ->add_option("images", o.images, "Folder")
      ->required()
      ->check(CLI::ExistingDirectory);
  const FacetTasks facets = AddFacetTasks(app);
  const RigTasks rig = AddRigTasks(app);
  calibrate->add_option("--limit-px", o.calibration.limit_px, "Larger errors (RMS) are an error")
      ->check(CLI::Range(0.01, 100.0));
  calibrate->add_flag("--fit-k3", o.calibration.fit_k3, "For wide lenses: fit k3 too");
  app.footer(
      "EXAMPLE\n  acus-camera sample --count 12 -o sample\n"
      "  acus-camera calibrate sample/board -o calibrated\n"
      "  acus-camera track sample/facets --camera calibrated/camera.json -o tracked");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    acus::AtomicFolder folder(o.output, context.overwrite);
    if (!o.images.empty()) {
      for (const fs::path& file : ImageFiles(o.images)) context.provenance.AddInput(file);
    }
    if (print->parsed()) Print(o, folder.path(), context);
    if (calibrate->parsed()) Calibrate(o, folder.path(), context);
    std::cout << facets({.board = o.board, .facets = o.facets, .camera = o.camera}, folder.path(),
                        context);
    std::cout << rig(o.board, folder.path(), context);
    folder.Commit();
    return acus::ExitCode::kOk;
  });
}
