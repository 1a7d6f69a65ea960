// acus-import: recordings of other programs to session folders.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/run_main.h"
#include "acus/data/session/plus_config.h"
#include "acus/data/session/recording_import.h"
#include "acus/data/session/session_io.h"

int main(int argc, char** argv) {
  std::filesystem::path recording, output, plus_config, columns;
  std::vector<std::string> needle, probe;
  std::string reference;
  std::vector<double> face_px;
  acus::session::RecordingOptions options;
  CLI::App app{
      "Make a session folder of a recording: PLUS sequence, 3D Slicer scene, transform buffer of\n"
      "Perk Tutor, or a tracker's CSV. Prints what was found, and what is missing.",
      "acus-import"};
  app.add_option(
         "recording", recording,
         "PLUS .igs.mha/.igs.mhd/.igs.nrrd; Slicer .mrml, .mrb or folder; Perk Tutor .xml;\n"
         "a tracker's .csv or .txt")
      ->required()
      ->check(CLI::ExistingPath);
  app.add_option("-o,--output", output, "Session folder to make; without it, only the report");
  app.add_option("--needle", needle, "Frames that may be the needle; the first that is there");
  app.add_option("--probe", probe, "Frames that may be the probe; the first that is there");
  app.add_option("--reference", reference, "Frame of the poses");
  app.add_option("--face-px", face_px,
                 "Column and row of the transducer's middle, if the probe is\n"
                 "given as an image")
      ->expected(2);
  app.add_option("--plus-config", plus_config, "PLUS device set (.xml) with calibrations")
      ->check(CLI::ExistingFile);
  app.add_option("--frame-rate-hz", options.frame_rate_hz,
                 "Make up time stamps at this rate, if a frame has none")
      ->check(CLI::Range(0.01, 1e5));
  app.add_option(
      "--columns", columns,
      "Which columns of a .csv or .txt hold what (acus-columns JSON): a file, or a preset\n"
      "such as columns/optitrack_motive.json");
  using acus::session::TimeGoingBack;
  app.add_option(
         "--time-goes-back", options.time_going_back,
         "Frames of a sequence that are earlier than one before: refuse, drop them, or cut\n"
         "the recording there")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, TimeGoingBack>{{"refuse", TimeGoingBack::kRefuse},
                                               {"drop", TimeGoingBack::kDrop},
                                               {"cut", TimeGoingBack::kCut}}));
  app.add_flag("--as-it-is", options.as_it_is,
               "Take positions that look like another unit as they are");
  app.footer(
      "EXAMPLE\n"
      "  acus-import session -o imported\n"
      "  The folder is read by acus-replay, acus-devices and acus-register.");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    auto& frames = options.frames;
    if (!needle.empty()) frames.needle_frames = needle;
    if (!probe.empty()) frames.probe_frames = probe;
    if (!reference.empty()) frames.reference_frame = reference;
    if (!face_px.empty()) frames.face_px = Eigen::Vector2d(face_px[0], face_px[1]);
    if (!plus_config.empty()) {
      frames.calibrations = acus::session::ReadPlusCalibrations(plus_config);
      context.provenance.AddInput(plus_config);
    }
    if (!columns.empty()) {
      options.columns = acus::config::FindConfig(columns, std::filesystem::current_path());
      context.provenance.AddInput(options.columns);
    }
    context.provenance.AddInput(recording);
    const auto imported = acus::session::ImportRecording(recording, options, context);
    if (!output.empty()) acus::session::WriteSession(output, imported.session, context);
    std::cout << acus::session::ImportReport(imported);
    return acus::ExitCode::kOk;
  });
}
