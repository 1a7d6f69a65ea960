// The task of acus-register on the clocks of two recordings.
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/report/residual_plot.h"
#include "acus/patient/registration/image_motion.h"
#include "acus/patient/registration/pose_log.h"
#include "acus/patient/registration/result_folder.h"
#include "acus/patient/registration/tasks.h"
#include "acus/patient/registration/temporal.h"

namespace acus::registration {
namespace {

report::Plot LagPlot(const TemporalCalibration& found) {
  report::Plot plot;
  plot.title = "Motion explained at each lag";
  plot.x_label = "lag [s]";
  plot.y_label = "share of variance";
  plot.series.push_back(
      {.name = "explained", .x = found.searched_lag_s, .y = found.searched_share});
  return plot;
}

std::vector<double> DetectorLags(const TemporalCalibration& found, double delay_s) {
  std::vector<double> lags_s = found.detector_lag_s;
  for (double& lag_s : lags_s) lag_s += delay_s;
  return lags_s;
}

}  // namespace

std::string Run(const TemporalTask& task, const std::filesystem::path& folder,
                RunContext& context) {
  const auto tracker = ReadTool(task.tracker, context);
  if (!task.video.empty()) context.provenance.AddInput(task.video);
  std::vector<MotionSignal> detectors;
  if (task.video.empty()) {
    detectors.push_back(PositionsOf(ReadTool(task.other, context)));
  } else {
    detectors = LineMotion(task.video, context);
  }
  const auto delay_ns = static_cast<std::int64_t>(task.delay_s * 1e9);
  for (MotionSignal& detector : detectors) {
    for (std::int64_t& time_ns : detector.time_ns) time_ns += delay_ns;
  }
  const TemporalCalibration found = CalibrateTime(tracker, detectors, task.settings);
  if (!task.video.empty() && found.detector_lag_s.size() < 2) {
    context.Warn(
        "only one way to find the line follows the motion: an error of the lag by how the "
        "line's image changes is not in the interval");
  }
  const double lag_s = found.lag_s + task.delay_s;
  AtomicFolder output(folder, context.overwrite);
  WriteResult(output.path(),
              {{"format", "acus-temporal/1"},
               {"lag_s", lag_s},
               {"lag_sd_s", found.sd_s},
               {"lag_half_width_95_s", found.half_width_s},
               {"detector_lags_s", DetectorLags(found, task.delay_s)},
               {"num_cycles", found.num_cycles},
               {"explained_share", found.explained_share},
               {"num_samples", found.num_samples}},
              context);
  report::WriteSvg(output.path() / "lags.svg", LagPlot(found));
  output.Commit();
  return Message(task.video.empty() ? "add to the other's times  " : "add to the video's times  ",
                 FixedText(1e3 * lag_s, 2), " ms (95 %: +- ",
                 RoundedText(1e3 * found.half_width_s, 2), " ms)\nmotion explained          ",
                 FixedText(100.0 * found.explained_share, 2), " % of the variance over ",
                 found.num_samples, " samples\n");
}

}  // namespace acus::registration
