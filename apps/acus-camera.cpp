// acus-camera: print boards and facets, calibrate and place cameras, track facets in images.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/run_main.h"
#include "acus/rig/camera/calibration.h"
#include "acus/rig/camera/rig_tasks.h"
#include "acus/rig/camera/sheet.h"
#include "acus/rig/camera/tracking_run.h"

namespace {

namespace fs = std::filesystem;
using namespace acus::camera;

struct Options {
  fs::path board = "cameras/board_a4.json", facets = "facets/training.json", images, output;
  fs::path camera = "cameras/webcam_720p.json", right, stereo;
  CalibrationSettings calibration;
  double rate_hz = 30.0;
  int count = 20;
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

void Track(const Options& o, const fs::path& folder, acus::RunContext& context) {
  const FacetSet facets = ReadFacets(Find(o.facets, context));
  const auto run =
      o.right.empty() ? TrackImages(ImageFiles(o.images), ReadCamera(Find(o.camera, context)),
                                    facets, o.rate_hz, context)
                      : TrackPairs(ImageFiles(o.images), ImageFiles(o.right),
                                   ReadStereo(Find(o.stereo, context)), facets, o.rate_hz, context);
  WriteResult(folder, run, context);
  std::cout << TableText(run);
}

void Sample(const Options& o, const fs::path& folder, acus::RunContext& context) {
  const CalibrationBoard board = ReadBoard(Find(o.board, context));
  const FacetSet facets = ReadFacets(Find(o.facets, context));
  if (o.stereo.empty()) {
    const CameraModel camera = ReadCamera(Find(o.camera, context));
    const Viewpoint view{.camera = &camera};
    WriteSamples(folder, {&view, 1}, board, facets, o.count, context);
    return;
  }
  const StereoPair pair = ReadStereo(Find(o.stereo, context));
  const Viewpoint views[] = {{.camera = &pair.left},
                             {.camera = &pair.right, .here_from_first = pair.right_from_left}};
  WriteSamples(folder, views, board, facets, o.count, context);
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
  auto* track = app.add_subcommand("track", "Images of facets to poses, with their jitter");
  auto* sample = app.add_subcommand("sample", "Draw images to try the others with");
  for (CLI::App* command : {calibrate, track}) {
    command->fallthrough()
        ->add_option("images", o.images, "Folder")
        ->required()
        ->check(CLI::ExistingDirectory);
  }
  const RigTasks rig = AddRigTasks(app);
  calibrate->add_option("--limit-px", o.calibration.limit_px, "Larger errors (RMS) are an error")
      ->check(CLI::Range(0.01, 100.0));
  calibrate->add_flag("--fit-k3", o.calibration.fit_k3, "For wide lenses: fit k3 too");
  track->add_option("--rate-hz", o.rate_hz, "Of the images")->check(CLI::Range(0.01, 1e4));
  auto* stereo = track->add_option("--stereo", o.stereo, "Track by this pair (stereo.json)");
  auto* right = track->add_option("--right", o.right, "Folder of its right camera's images")
                    ->check(CLI::ExistingDirectory)
                    ->needs(stereo);
  stereo->needs(right);
  sample->add_option("--stereo", o.stereo, "Draw for both cameras of a pair (stereo.json)");
  sample->fallthrough()->add_option("--count", o.count, "Images")->check(CLI::Range(1, 9999));
  app.footer(
      "EXAMPLE\n  acus-camera sample --count 12 -o sample\n"
      "  acus-camera calibrate sample/board -o calibrated\n"
      "  acus-camera track sample/facets --camera calibrated/camera.json -o tracked");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    acus::AtomicFolder folder(o.output, context.overwrite);
    if (!o.images.empty()) {
      for (const fs::path& file : ImageFiles(o.images)) context.provenance.AddInput(file);
    }
    if (!o.right.empty()) {
      for (const fs::path& file : ImageFiles(o.right)) context.provenance.AddInput(file);
    }
    if (print->parsed()) Print(o, folder.path(), context);
    if (calibrate->parsed()) Calibrate(o, folder.path(), context);
    if (track->parsed()) Track(o, folder.path(), context);
    if (sample->parsed()) Sample(o, folder.path(), context);
    std::cout << rig(o.board, folder.path(), context);
    folder.Commit();
    return acus::ExitCode::kOk;
  });
}
