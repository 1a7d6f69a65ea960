// acus-breathing: how a patient moves as he breathes, from a 4D CT, fields or a single CT.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/core/run_main.h"
#include "acus/patient/breathing_registration/capture_folder.h"
#include "acus/patient/breathing_registration/capture_inputs.h"

namespace {

namespace fs = std::filesystem;
using namespace acus::breathing_registration;

struct Options {
  CaptureInputs inputs;
  std::string model = "surrogate";
  fs::path output;
  bool no_sliding = false;
  CaptureSettings settings;
};

acus::ExitCode Run(Options& options, acus::RunContext& context) {
  CaptureInputs& inputs = options.inputs;
  inputs.sliding = !options.no_sliding;
  options.settings.kind = acus::breathing::MotionKindOf(options.model);
  for (const fs::path& path :
       {inputs.phases, inputs.fields, inputs.ct, inputs.single, inputs.signal}) {
    if (!path.empty()) context.provenance.AddInput(path);
  }
  const Capture capture = CaptureFrom(inputs, options.settings, context);
  WriteCapture(options.output, capture, context);
  std::cout << CaptureText(capture);
  return acus::ExitCode::kOk;
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CaptureInputs& in = o.inputs;
  CLI::App app{"Register the phases of a 4D CT and make a model of how the patient breathes.",
               "acus-breathing"};
  auto* from = app.add_option_group("from", "One of");
  from->add_option(
          "phases", in.phases,
          "4D CT: folder of phases (DICOM, NIfTI, MetaImage, NRRD), or a NIfTI file of all")
      ->check(CLI::ExistingPath);
  auto* given_fields =
      from->add_option("--fields", in.fields, "Folder of displacement fields instead of images")
          ->check(CLI::ExistingDirectory);
  from->add_option("--single", in.single, "A CT at end expiration: a synthetic breath fitted to it")
      ->check(CLI::ExistingPath);
  from->require_option(1);
  app.add_option("--signal", in.signal, "Recorded surrogate: levels of phases, period")
      ->check(CLI::ExistingFile);
  app.add_option("--column", in.column, "Of the signal's file");
  app.add_option("--ct", in.ct, "The patient's CT, which --fields must lie on")
      ->check(CLI::ExistingPath)
      ->needs(given_fields);
  app.add_option("--labels", in.labels, "Tissues of the reference; default: found")
      ->check(CLI::ExistingFile);
  app.add_option("--landmarks", in.landmarks, "Known places; default: landmarks.csv of the folder")
      ->check(CLI::ExistingFile);
  app.add_option("--model", o.model, "What to write")
      ->check(CLI::IsMember({"sinusoid", "full_cycle", "half_cycle", "surrogate"}));
  app.add_option("--resolution", o.settings.resolution, "Nodes along each axis")
      ->check(CLI::Range(16, 256));
  app.add_option("--modes", o.settings.num_modes, "Principal components over time; 0: all")
      ->check(CLI::Range(0, 60));
  app.add_option("--spacing-mm", o.settings.registration.spacing_mm,
                 "Of the registration's grid; default: 2, or more where voxels are larger or the "
                 "patient is large, so that ten phases take about a minute on two cores")
      ->check(CLI::Range(0.5, 20.0));
  app.add_option("--diaphragm-mm", in.diaphragm_mm, "Travel of the diaphragm, with --single")
      ->check(CLI::Range(0.0, 80.0));
  app.add_flag("--no-sliding", o.no_sliding, "Organs do not slide along the ribs");
  app.add_option("-o,--output", o.output, "Folder to write")->required();
  app.footer(
      "EXAMPLE\n"
      "  acus-breathing breathing_patient --spacing-mm 6 --resolution 64 -o motion\n"
      "  acus-breathing --single liver_patient/ct.nrrd --resolution 32 -o synthetic\n");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) { return Run(o, context); });
}
