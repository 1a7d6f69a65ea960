// A sweep as images: error against time, setting by setting.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/assess/tuning/goal.h"
#include "acus/assess/tuning/sweep_result.h"
#include "acus/base/report/svg_plot.h"

namespace acus::tuning {

/// What a plot shows beside the settings.
struct PlotRemarks {
  std::optional<Goal> goal;         ///< Its limits are dashed lines.
  std::optional<Setting> chosen;    ///< Marked by a star.
  std::optional<std::string> knob;  ///< Only settings of this knob's sweep.
};

/// Error of the force over time of a step, error of the images (PSNR, and what SSIM is short of
/// 1) over time of an image: those for which there are two points to show. Points are means over
/// repetitions, bars their 95 % intervals. Times are medians, or with a budget the percentiles that
/// it is for. Lines are Pareto fronts: of each knob, or of all settings if they were compared with
/// the same one. Rings are our defaults - of a joint setting the scenario's own -, diamonds what
/// papers did. Unusable settings and those without an error (the most expensive) are not shown.
std::vector<report::Plot> TradeoffPlots(const SweepResult& result, const PlotRemarks& remarks);

}  // namespace acus::tuning
