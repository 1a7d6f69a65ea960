// What a registration or calibration leaves at each point.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/base/report/svg_plot.h"

namespace acus::report {

/// Residuals as bars over the names of their points (numbers, if there are none), with the error
/// that the other points predict for each as a dot, where there is one.
Plot ResidualPlot(const std::string& title, const std::vector<std::string>& names,
                  const std::vector<double>& residual_mm,
                  const std::vector<std::optional<double>>& error_by_others_mm = {});

}  // namespace acus::report
