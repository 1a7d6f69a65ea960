// acus-dataset: labelled ultrasound images of many patients, for the training of networks.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/assess/dataset/dataset.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/run_main.h"

int main(int argc, char** argv) {
  std::filesystem::path config_path, output;
  std::string format = "png";
  bool check = false;
  auto formats = acus::replay::LabelFormats();
  formats.erase("none");

  CLI::App app{
      "Make a data set of labelled ultrasound images: insertions by virtual trainees, with "
      "tissues,\n"
      "needle, tip and target of every pixel, poses and forces, split by patient. Patients, "
      "probes,\n"
      "gains, needles and motions vary by --seed.",
      "acus-dataset"};
  app.add_option("config", config_path, "Patients, tools and ranges (acus-dataset JSON)")
      ->required();
  app.add_option("-o,--output", output, "Folder to make");
  app.add_option("--format", format, "Files of images and labels: png, nifti, or hdf5")
      ->check(CLI::IsMember(formats))
      ->capture_default_str();
  app.add_flag("--check", check, "Print splits and sequences, and make nothing");
  app.callback([&] {
    if (output.empty() && !check) throw CLI::RequiredError("--output");
  });
  app.footer(
      "EXAMPLE\n"
      "  acus-dataset dataset.json --seed 7 -o dataset\n"
      "  Training code begins with dataset/manifest.json and dataset/frames.csv.");

  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    const auto file = acus::config::FindConfig(config_path, std::filesystem::current_path());
    const auto config = acus::dataset::ReadDatasetConfig(file);
    std::cout << (check ? acus::dataset::PlanText(config, context.seed)
                        : acus::dataset::WriteDataset(config, formats.at(format), output, context));
    return acus::ExitCode::kOk;
  });
}
