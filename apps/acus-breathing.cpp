// acus-breathing: how a patient moves as he breathes, from a 4D CT, fields or a single CT.
#include <CLI/CLI.hpp>
#include <iostream>

#include "core/run_main.h"
#include "motion_capture/capture_folder.h"
#include "motion_capture/patient_tissue.h"

namespace {

namespace fs = std::filesystem;
using namespace acus::motion_capture;

struct Options {
  fs::path folder, fields, single, signal, labels, landmarks, output;
  std::string column, model = "surrogate";
  double diaphragm_mm = 20.0;
  bool no_sliding = false;
  CaptureSettings settings;
};

Capture FromImages(const Options& options, const PhaseFiles& files, acus::RunContext& context) {
  const auto reference = ReadPhase(files.phases[ReferenceOf(files)], context);
  const auto tissue = TissueOf(reference, options.labels, !options.no_sliding, context);
  fs::path landmarks = options.landmarks;
  if (landmarks.empty() && fs::exists(options.folder / "landmarks.csv")) {
    landmarks = options.folder / "landmarks.csv";
  }
  return CaptureMotion(files, reference, tissue,
                       landmarks.empty() ? KnownLandmarks{} : ReadKnownLandmarks(landmarks),
                       options.settings, context);
}

acus::ExitCode Run(Options& options, acus::RunContext& context) {
  options.settings.kind = acus::breathing::MotionKindOf(options.model);
  std::optional<acus::breathing::BreathSignal> signal;
  for (const fs::path& path : {options.folder, options.fields, options.single, options.signal}) {
    if (!path.empty()) context.provenance.AddInput(path);
  }
  if (!options.signal.empty()) {
    signal = acus::breathing::ReadBreathSignal(options.signal, {.column = options.column});
  }
  Capture capture = [&] {
    if (!options.single.empty()) {
      const auto ct = acus::volume::ReadCt(options.single, "", context);
      return CaptureSingle(acus::segmentation::TissuesOf(ct, options.labels, context),
                           options.diaphragm_mm, options.settings, context);
    }
    if (!options.fields.empty()) {
      return CaptureFields(FindPhases(options.fields, signal), nullptr, options.settings, context);
    }
    return FromImages(options, FindPhases(options.folder, signal), context);
  }();
  WriteCapture(options.output, capture, context);
  std::cout << CaptureText(capture);
  return acus::ExitCode::kOk;
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App app{"Register the phases of a 4D CT and make a model of how the patient breathes.",
               "acus-breathing"};
  auto* from = app.add_option_group("from", "One of");
  from->add_option("phases", o.folder,
                   "4D CT: folder of phases (DICOM with temporal position, NIfTI, MetaImage, NRRD)")
      ->check(CLI::ExistingDirectory);
  from->add_option("--fields", o.fields, "Folder of displacement fields instead of images")
      ->check(CLI::ExistingDirectory);
  from->add_option("--single", o.single, "A CT at end expiration: a synthetic breath fitted to it")
      ->check(CLI::ExistingPath);
  from->require_option(1);
  app.add_option("--signal", o.signal, "Recorded surrogate: levels of the phases")
      ->check(CLI::ExistingFile);
  app.add_option("--column", o.column, "Of the signal's file");
  app.add_option("--labels", o.labels, "Tissues of the reference; default: found")
      ->check(CLI::ExistingFile);
  app.add_option("--landmarks", o.landmarks, "Known places; default: landmarks.csv of the folder")
      ->check(CLI::ExistingFile);
  app.add_option("--model", o.model, "What to write")
      ->check(CLI::IsMember({"sinusoid", "full_cycle", "half_cycle", "surrogate"}));
  app.add_option("--resolution", o.settings.resolution, "Nodes along each axis")
      ->check(CLI::Range(16, 256));
  app.add_option("--modes", o.settings.num_modes, "Principal components over time; 0: all")
      ->check(CLI::Range(0, 60));
  app.add_option("--spacing-mm", o.settings.registration.spacing_mm, "Of the registration's grid")
      ->check(CLI::Range(0.5, 20.0));
  app.add_option("--diaphragm-mm", o.diaphragm_mm, "Way of the diaphragm, with --single")
      ->check(CLI::Range(0.0, 80.0));
  app.add_flag("--no-sliding", o.no_sliding, "Organs do not slide along the ribs");
  app.add_option("-o,--output", o.output, "Folder to write")->required();
  app.footer(
      "EXAMPLE\n"
      "  acus-breathing breathing_patient --spacing-mm 6 --resolution 64 -o motion\n"
      "  acus-breathing --single liver_patient/ct.nrrd --resolution 32 -o synthetic\n");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) { return Run(o, context); });
}
