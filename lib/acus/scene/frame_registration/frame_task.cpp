#include "acus/scene/frame_registration/frame_task.h"

#include <CLI/CLI.hpp>
#include <memory>
#include <opencv2/imgcodecs.hpp>

#include "acus/base/config/pose_json.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/data/image/png.h"
#include "acus/data/transforms/transform_file.h"
#include "acus/imaging/ultrasound/aperture/aperture_renderer.h"
#include "acus/patient/registration/result_folder.h"
#include "acus/scene/frame_registration/frame_patient.h"

namespace acus::frame_registration {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Tissue within this many standard deviations of the start is kept.
constexpr double kMarginSd = 4.0;

image::GrayImage ReadFrame(const fs::path& path, RunContext& context) {
  context.provenance.AddInput(path);
  cv::Mat grey;
  try {
    grey = cv::imread(path.string(), cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    grey.release();
  }
  ACUS_REQUIRE(!grey.empty(), path.string(),
               ": is no image that can be read; give a PNG or another common format, not cut off");
  image::GrayImage out;
  out.Resize(grey.cols, grey.rows);
  grey.copyTo(cv::Mat(grey.rows, grey.cols, CV_8U, out.pixels.data()));
  return out;
}

scenario::Scenario ReadTaskScenario(const FrameTask& task, RunContext& context) {
  context.provenance.AddInput(task.scenario);
  std::vector<scenario::Override> changes;
  const auto change = [&](const char* pointer, const fs::path& path) {
    if (!path.empty()) changes.push_back({pointer, path.string()});
  };
  change("/patient/ct", task.ct);
  change("/patient/labels", task.labels);
  change("/patient/surfaces", task.surfaces);
  return scenario::ReadScenario(task.scenario, changes);
}

acoustics::Probe ReadTaskProbe(const scenario::Scenario& scenario, RunContext& context) {
  acoustics::Probe probe = acoustics::ReadProbe(scenario.probe);
  context.provenance.AddInput(scenario.probe);
  if (!scenario.ultrasound) return probe;
  if (scenario.ultrasound->scan_lines > 0) probe.scan_lines = scenario.ultrasound->scan_lines;
  if (scenario.ultrasound->samples_per_line > 0) {
    probe.samples_per_line = scenario.ultrasound->samples_per_line;
  }
  return probe;
}

/// Recorded, simulated, and both: recorded in magenta, simulated in green.
image::ColourImage Overlay(const image::GrayImage& recorded, const image::GrayImage& simulated) {
  image::ColourImage out;
  out.Resize(3 * recorded.width, recorded.height);
  for (int r = 0; r < recorded.height; ++r) {
    for (int c = 0; c < recorded.width; ++c) {
      const std::uint8_t a = recorded.At(c, r);
      const std::uint8_t b = simulated.At(c, r);
      const std::uint8_t panels[3][3] = {{a, a, a}, {b, b, b}, {a, b, a}};
      for (int p = 0; p < 3; ++p) {
        const int at = 3 * (r * out.width + p * recorded.width + c);
        std::copy_n(panels[p], 3, out.rgb.begin() + at);
      }
    }
  }
  return out;
}

json ToJson(const FramePose& pose, const SearchSettings& settings) {
  json change;
  json sd;
  json determined;
  const auto is_determined = pose.determined(settings);
  json covariance = json::array();
  for (int k = 0; k < 6; ++k) {
    const std::string name(kChangeNames[static_cast<std::size_t>(k)]);
    change[name] = pose.change[k];
    sd[name] = pose.sd[k];
    determined[name] = is_determined[static_cast<std::size_t>(k)];
    covariance.push_back(
        std::vector<double>(pose.covariance.row(k).begin(), pose.covariance.row(k).end()));
  }
  json out = {{"format", "acus-frame-registration/1"},
              {"ct_from_probe", config::MatrixRows(pose.ct_from_probe)},
              {"change_from_start", change},
              {"standard_deviation", sd},
              {"determined", determined},
              {"covariance", covariance},
              {"similarity", pose.similarity},
              {"start_similarity", pose.start_similarity},
              {"start_sd_mm", settings.start_mm},
              {"start_sd_deg", settings.start_deg}};
  if (pose.rival_mm) out["rival_mm"] = *pose.rival_mm;
  return out;
}

std::string PoseText(const FramePose& pose, const SearchSettings& settings) {
  const auto is_determined = pose.determined(settings);
  std::vector<std::vector<std::string>> rows;
  for (int k = 0; k < 6; ++k) {
    const auto n = static_cast<std::size_t>(k);
    rows.push_back({std::string(kChangeNames[n]), FixedText(pose.change[k], 2),
                    FixedText(pose.sd[k], 2), is_determined[n] ? "yes" : "no"});
  }
  return TextTable({"direction", "change from start", "standard deviation", "determined"}, rows) +
         Message("explained share of the frame's local variance ", FixedText(pose.similarity, 3),
                 ", at the start ", FixedText(pose.start_similarity, 3), "\n");
}

void WarnOf(const FramePose& pose, const SearchSettings& settings, const RunContext& context) {
  if (pose.rival_mm) {
    context.Warn(Message("another pose, ", FixedText(*pose.rival_mm, 1),
                         " mm away in the image plane, fits about as well; give a better start "
                         "and its standard deviations (--start-mm, --start-deg)"));
  }
  if (pose.change.head<3>().cwiseAbs().maxCoeff() > 3.0 * settings.start_mm ||
      pose.change.tail<3>().cwiseAbs().maxCoeff() > 3.0 * settings.start_deg) {
    context.Warn(
        "the pose is more than three standard deviations from the start; give larger ones "
        "(--start-mm, --start-deg) if the start may be that far off");
  }
}

}  // namespace

std::string Run(const FrameTask& task, const fs::path& folder, RunContext& context) {
  const scenario::Scenario scenario = ReadTaskScenario(task, context);
  const acoustics::Probe probe = ReadTaskProbe(scenario, context);
  const image::GrayImage recorded = ReadFrame(task.frame, context);
  context.provenance.AddInput(task.start);
  const Eigen::Isometry3d start = transforms::ReadTransform(task.start);
  const FramePatient patient = ReadFramePatient(scenario, task.background, probe, start,
                                                kMarginSd * task.settings.start_mm, context);
  const FramePose pose =
      FindFramePose(recorded, probe, patient.tissue(), start, task.settings, context);
  WarnOf(pose, task.settings, context);
  image::GrayImage simulated;
  ultrasound::ApertureRenderer(patient.tissue().tissue, probe, patient.settings.options,
                               context.num_threads)
      .Render(pose.ct_from_probe, {}, simulated, context.num_threads);
  AtomicFolder output(folder, context.overwrite);
  registration::WriteResult(output.path(), ToJson(pose, task.settings), context);
  transforms::WriteTransform(output.path() / "ct_from_probe.tfm", pose.ct_from_probe,
                             "ct_from_probe: takes points of the probe to CT (LPS, mm)");
  image::WritePng(output.path() / "overlay.png", Overlay(recorded, simulated),
                  context.provenance.OneLine());
  output.Commit();
  return PoseText(pose, task.settings);
}

registration::Command AddFrameTask(CLI::App& app) {
  const auto task = std::make_shared<FrameTask>();
  CLI::App* command = app.add_subcommand(
      "image", "Find the pose of the probe whose simulated image fits a recorded frame");
  command->add_option("frame", task->frame, "The recorded frame, as the probe's image: a PNG")
      ->required()
      ->check(CLI::ExistingFile);
  command
      ->add_option("--scenario", task->scenario,
                   "Patient, probe and ultrasound (model aperture) that the frame is of")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--start", task->start, "A rough ct_from_probe.tfm")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--ct", task->ct, "The patient's CT, in place of the scenario's")
      ->check(CLI::ExistingPath);
  command->add_option("--labels", task->labels, "The patient's labels, in place of the scenario's")
      ->check(CLI::ExistingFile);
  command
      ->add_option("--surfaces", task->surfaces,
                   "Or a list of labelled surfaces (format acus-surface-scene/1)")
      ->check(CLI::ExistingFile);
  command->add_option("--background", task->background,
                      "Tissue wherever nothing is labelled, as muscle around a bone's surface");
  command
      ->add_option("--start-mm", task->settings.start_mm,
                   "Standard deviation of the start's place along each axis")
      ->check(CLI::Range(0.1, 50.0))
      ->capture_default_str();
  command
      ->add_option("--start-deg", task->settings.start_deg,
                   "Standard deviation of the start's rotation about each axis")
      ->check(CLI::Range(0.1, 45.0))
      ->capture_default_str();
  command->add_option("--samples", task->settings.samples, "Poses around the start that are tried")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  return {.app = command,
          .run = [task](const fs::path& folder,
                        RunContext& context) { return Run(*task, folder, context); },
          .shared_options = {}};
}

}  // namespace acus::frame_registration
