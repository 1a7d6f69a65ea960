// acus-rf: raw ultrasound data, simulated or recorded, and the image that delay and sum makes.
#include <CLI/CLI.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/run_main.h"
#include "acus/data/image/png.h"
#include "acus/imaging/rf/compression.h"
#include "acus/imaging/rf/matlab_file.h"
#include "acus/imaging/rf/numpy_file.h"
#include "acus/imaging/rf/rf_lines.h"
#include "acus/imaging/rf/rf_settings.h"

namespace {

using namespace acus;  // NOLINT: a program may.
namespace fs = std::filesystem;

rf::ChannelData Simulate(const rf::RfSettings& settings, const RunContext& context) {
  const rf::ChannelSimulator simulator(settings.array, settings.pulse, settings.transmits,
                                       settings.channels);
  rf::ChannelData data = simulator.Empty();
  context.Checkpoint("simulating", 0.0);
  simulator.Add(settings.points, context.num_threads, data);
  simulator.Add(rf::ScatterersIn(settings.speckle, context.seed), context.num_threads, data);
  return data;
}

void WriteImage(const fs::path& folder, const rf::ChannelData& data, const rf::RfSettings& settings,
                const RunContext& context) {
  context.Checkpoint("delay and sum", 0.8);
  const rf::Baseband baseband = rf::BasebandOf(data, settings.pulse.frequency_mhz,
                                               settings.baseband_oversampling, context.num_threads);
  const rf::IqImage image = rf::DelayAndSum(baseband, settings.array, settings.transmits,
                                            settings.grid, settings.beamform, context.num_threads);
  rf::WriteNumpy(folder / "iq.npy", image);
  rf::WriteRfLines(folder / "rf_lines.mha", image);
  image::WritePng(folder / "bmode.png", rf::Compressed(image, settings.dynamic_range_db),
                  context.provenance.OneLine());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Raw ultrasound data: simulates channel data, and makes images of them", "acus-rf");
  fs::path settings_path, recording, output;
  std::string variable;
  app.require_subcommand(1);
  app.fallthrough();
  auto* simulate = app.add_subcommand("simulate", "Channel data of points and speckle, and image");
  auto* beamform = app.add_subcommand("beamform", "The image of recorded channel data");
  for (CLI::App* command : {simulate, beamform}) {
    command->add_option("SETTINGS", settings_path, "Acquisition and image (format acus-rf/1)")
        ->required();
    command->add_option("-o,--output", output, "Folder to make")->required();
  }
  beamform
      ->add_option("--data", recording,
                   "MATLAB file: samples x elements x transmissions, any real class")
      ->required()
      ->check(CLI::ExistingFile);
  beamform->add_option("--variable", variable, "Its variable; default: that of the settings");
  app.footer(
      "Writes iq.npy (complex, rows x columns), rf_lines.mha (PLUS, RF_REAL) and bmode.png;\n"
      "simulate also channels.npy (transmissions x elements x samples) and channels.mat.\n\n"
      "EXAMPLE\n  acus-rf simulate rf/three_points.json -o simulated\n"
      "  acus-rf beamform rf/three_points.json --data simulated/channels.mat -o image\n");

  return RunMain(app, argc, argv, [&](RunContext& context) {
    settings_path = config::FindConfig(settings_path, ".");
    const rf::RfSettings settings = rf::ReadRfSettings(settings_path);
    context.provenance.AddInput(settings_path);
    AtomicFolder folder(output, context.overwrite);
    rf::ChannelData data;
    if (simulate->parsed()) {
      data = Simulate(settings, context);
      rf::WriteNumpy(folder.path() / "channels.npy", data);
      rf::WriteMatlab(folder.path() / "channels.mat", data);
    } else {
      context.provenance.AddInput(recording);
      data = rf::ReadRecording(recording, settings, variable);
    }
    WriteImage(folder.path(), data, settings, context);
    config::WriteJson(folder.path() / "provenance.json", context.provenance.ToJson());
    folder.Commit();
    return ExitCode::kOk;
  });
}
