// Plots of a sweep: error against time, by setting.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/assess/tuning/goal.h"
#include "acus/assess/tuning/sweep_result.h"
#include "acus/base/report/svg_plot.h"

namespace acus::tuning {

/// The marks of a plot beside the settings.
struct PlotRemarks {
  std::optional<Goal> goal;         ///< Its limits are dashed lines.
  std::optional<Setting> chosen;    ///< Marked by a star.
  std::optional<std::string> knob;  ///< Only settings of this parameter's sweep.
};

/// Error of the force over time of a step, error of the images (PSNR, and 1 - SSIM) over time of an
/// image: those with at least two points. Points are means over repetitions, bars their 95 %
/// intervals. Times are medians, or with a budget the percentiles that it limits. Lines are Pareto
/// fronts: of each parameter, or of all settings if they were compared with the same one. Rings are
/// our defaults - for a joint setting the scenario's own -, diamonds the values of papers. Unusable
/// settings and those without an error (the most expensive) are not shown.
std::vector<report::Plot> TradeoffPlots(const SweepResult& result, const PlotRemarks& remarks);

}  // namespace acus::tuning
