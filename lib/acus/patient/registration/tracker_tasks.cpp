// Tasks on recordings of trackers: jitter, accuracy, hand-eye calibration.
#include <algorithm>

#include "acus/base/config/pose_json.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/report/residual_plot.h"
#include "acus/data/transforms/transform_file.h"
#include "acus/patient/registration/hand_eye.h"
#include "acus/patient/registration/pose_log.h"
#include "acus/patient/registration/result_folder.h"
#include "acus/patient/registration/tasks.h"
#include "acus/patient/registration/tracker_quality.h"

namespace acus::registration {
namespace {

namespace fs = std::filesystem;
using config::MatrixRows;
using config::Row;
using Eigen::Isometry3d;
using nlohmann::json;

/// Distance of each coordinate from the mean over the still stretch.
report::Plot JitterPlot(const session::PoseStream& stream, const Jitter& jitter) {
  report::Plot plot;
  plot.title = jitter.tool + ": distance from the mean";
  plot.x_label = "time [s]";
  plot.y_label = "mm";
  const char* names[] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    report::Series series{.name = names[axis]};
    for (std::size_t i = jitter.first; i <= jitter.last; ++i) {
      if (!stream[i].valid) continue;
      series.x.push_back(static_cast<double>(stream[i].time_ns - stream[jitter.first].time_ns) *
                         1e-9);
      series.y.push_back(stream[i].reference_from_tool.translation()[axis] - jitter.mean_mm[axis]);
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

report::Plot AccuracyPlot(const PlaceAccuracy& accuracy) {
  report::Plot plot;
  plot.title = "Errors of known distances";
  plot.x_label = "true distance [mm]";
  plot.y_label = "measured minus true [mm]";
  plot.y_from_zero = true;
  report::Series dots{.name = "pairs of places", .style = report::Style::kPoints};
  for (const auto& distance : accuracy.distances) {
    dots.x.push_back(distance.true_mm);
    dots.y.push_back(distance.error_mm);
  }
  plot.series.push_back(std::move(dots));
  return plot;
}

json ToJson(const Jitter& j) {
  return {{"tool", j.tool},
          {"num_samples", j.num_samples},
          {"num_invalid", j.num_invalid},
          {"num_repeated", j.num_repeated},
          {"duration_s", j.duration_s},
          {"rate_hz", j.rate_hz},
          {"whole_recording", j.whole_recording},
          {"mean_mm", Row(j.mean_mm)},
          {"sd_mm", Row(j.sd_mm)},
          {"rms_mm", j.rms_mm},
          {"p95_mm", j.p95_mm},
          {"largest_mm", j.largest_mm},
          {"rms_deg", j.rms_deg},
          {"drift_mm", j.drift_mm},
          {"noise_mm", j.noise_mm},
          {"step_mm", j.step_mm}};
}

json ToJson(const PlaceAccuracy& a) {
  json distances = json::array();
  for (const auto& d : a.distances) {
    distances.push_back({{"from", a.names[static_cast<std::size_t>(d.from)]},
                         {"to", a.names[static_cast<std::size_t>(d.to)]},
                         {"true_mm", d.true_mm},
                         {"error_mm", d.error_mm}});
  }
  json document = {{"rms_mm", a.rms_mm},
                   {"mean_mm", a.mean_mm},
                   {"largest_mm", a.largest_mm},
                   {"scale", a.scale},
                   {"distances", distances}};
  if (a.has_places) document["place_rms_mm"] = a.place_rms_mm;
  return document;
}

std::string JitterText(const std::vector<Jitter>& all) {
  std::vector<std::vector<std::string>> rows;
  for (const Jitter& j : all) {
    rows.push_back({j.tool, FixedText(j.rms_mm, 3), FixedText(j.noise_mm, 3),
                    FixedText(j.p95_mm, 3), FixedText(j.rms_deg, 3), FixedText(j.drift_mm, 3),
                    FixedText(j.step_mm, 4), FixedText(j.duration_s, 1), FixedText(j.rate_hz, 1)});
  }
  return TextTable({"tool", "jitter mm RMS", "sample to sample mm", "95 % mm", "angle deg RMS",
                    "drift mm", "step mm", "still for s", "rate Hz"},
                   rows);
}

std::string AccuracyText(const PlaceAccuracy& a) {
  std::string text = Message("accuracy ", FixedText(a.rms_mm, 3), " mm RMS over ",
                             a.distances.size(), " known distances (mean ", FixedText(a.mean_mm, 3),
                             ", largest ", FixedText(a.largest_mm, 3), " mm; lengths ",
                             FixedText(100.0 * (a.scale - 1.0), 3), " % too long)\n");
  if (a.has_places) {
    text += Message("places ", FixedText(a.place_rms_mm, 3), " mm RMS after the best rigid fit of ",
                    a.names.size(), "\n");
  }
  return text;
}

/// Poses of both at the tracker's moments, where both are valid.
struct PosePairs {
  std::vector<Isometry3d> device_from_handle;
  std::vector<Isometry3d> tracker_from_marker;
};

PosePairs PairUp(const session::PoseStream& device, const session::PoseStream& tracker,
                 double delay_s) {
  PosePairs pairs;
  const auto delay_ns = static_cast<std::int64_t>(delay_s * 1e9);
  for (const session::PoseSample& sample : tracker) {
    const std::int64_t time_ns = sample.time_ns + delay_ns;
    const bool covered = time_ns >= device.front().time_ns && time_ns <= device.back().time_ns;
    if (!sample.valid || !covered) continue;
    const session::PoseSample at = session::PoseAt(device, time_ns);
    if (!at.valid) continue;
    pairs.device_from_handle.push_back(at.reference_from_tool);
    pairs.tracker_from_marker.push_back(sample.reference_from_tool);
  }
  ACUS_REQUIRE(!pairs.device_from_handle.empty(),
               "the two recordings have no moment in common: the "
               "device's runs from ",
               static_cast<double>(device.front().time_ns) * 1e-9, " to ",
               static_cast<double>(device.back().time_ns) * 1e-9, " s, the tracker's from ",
               static_cast<double>(tracker.front().time_ns) * 1e-9, " to ",
               static_cast<double>(tracker.back().time_ns) * 1e-9, " s; --delay-s shifts it");
  return pairs;
}

}  // namespace

std::string Run(const TrackerTask& task, const fs::path& folder, RunContext& context) {
  const bool has_places = !task.measured.empty() && !task.known.empty();
  ACUS_REQUIRE(!task.log.empty() || has_places,
               "a recording of still tools, or measured and known places, are needed");
  json document = {{"format", "acus-tracker/1"}};
  std::vector<Jitter> all;
  std::vector<report::Plot> plots;
  std::string text;
  if (!task.log.empty()) {
    const auto tools = task.tools.empty() ? ToolsOf(task.log, task.reference, context) : task.tools;
    for (const std::string& tool : tools) {
      const auto stream =
          ReadTool({.log = task.log, .tool = tool, .reference = task.reference}, context);
      all.push_back(MeasureJitter(stream, tool, task.still_mm));
      plots.push_back(JitterPlot(stream, all.back()));
      document["jitter"].push_back(ToJson(all.back()));
      if (!all.back().whole_recording) {
        text += Message("note: ", tool, " moved; jitter is that of its longest rest\n");
      }
    }
    text = JitterText(all) + text;
  }
  AtomicFolder output(folder, context.overwrite);
  if (has_places) {
    const auto accuracy = MeasureAccuracy(transforms::MatchLandmarks(
        ReadPoints(task.measured, context), ReadPoints(task.known, context), 2));
    document["accuracy"] = ToJson(accuracy);
    report::WriteSvg(output.path() / "accuracy.svg", AccuracyPlot(accuracy));
    text += AccuracyText(accuracy);
  }
  if (!plots.empty()) report::WriteSvg(output.path() / "jitter.svg", plots);
  WriteResult(output.path(), document, context);
  output.Commit();
  return text;
}

std::string Run(const HandEyeTask& task, const fs::path& folder, RunContext& context) {
  const PosePairs pairs =
      PairUp(ReadTool(task.device, context), ReadTool(task.tracker, context), task.delay_s);
  const HandEye result = CalibrateHandEye(pairs.device_from_handle, pairs.tracker_from_marker);
  RequireOneBody(result, task.limit_mm);
  const auto num_used = std::ranges::count(result.used, true);
  const json document = {{"format", "acus-hand-eye/1"},
                         {"handle_from_marker", MatrixRows(result.handle_from_marker)},
                         {"device_from_tracker", MatrixRows(result.device_from_tracker)},
                         {"rms_mm", result.rms_mm},
                         {"rms_deg", result.rms_deg},
                         {"turn_deg", result.turn_deg},
                         {"handle_sd_mm", Row(result.handle_sd_mm)},
                         {"device_sd_mm", Row(result.device_sd_mm)},
                         {"num_pairs", result.used.size()},
                         {"num_used", num_used},
                         {"residual_mm", result.residual_mm}};
  AtomicFolder output(folder, context.overwrite);
  WriteResult(output.path(), document, context);
  transforms::WriteTransform(
      output.path() / "handle_from_marker.tfm", result.handle_from_marker,
      "handle_from_marker: takes points of the marker's frame to the handle's (mm)");
  transforms::WriteTransform(
      output.path() / "device_from_tracker.tfm", result.device_from_tracker,
      "device_from_tracker: takes points of the tracker's frame to the device's (mm)");
  report::WriteSvg(output.path() / "residuals.svg",
                   report::ResidualPlot("Residuals of the pairs", {}, result.residual_mm));
  output.Commit();
  return Message("marker in the handle's frame   ",
                 VectorText(result.handle_from_marker.translation(), 3), " mm\n",
                 "tracker in the device's frame  ",
                 VectorText(result.device_from_tracker.translation(), 3), " mm\n",
                 "standard errors                ", VectorText(result.handle_sd_mm, 3), " and ",
                 VectorText(result.device_sd_mm, 3), " mm along their principal directions\n",
                 "what remains                   ", FixedText(result.rms_mm, 3), " mm, ",
                 FixedText(result.rms_deg, 3), " deg RMS\n", "turned by                      ",
                 FixedText(result.turn_deg, 1), " deg RMS beside the main axis\n",
                 "pairs used                     ", num_used, " of ", result.used.size(), "\n");
}

}  // namespace acus::registration
