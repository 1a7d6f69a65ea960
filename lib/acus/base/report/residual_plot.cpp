#include "acus/base/report/residual_plot.h"

namespace acus::report {

Plot ResidualPlot(const std::string& title, const std::vector<std::string>& names,
                  const std::vector<double>& residual_mm,
                  const std::vector<std::optional<double>>& error_by_others_mm) {
  Plot plot;
  plot.title = title;
  plot.y_label = "distance [mm]";
  plot.x_label = names.empty() ? "number" : "";
  plot.x_names = names;
  Series bars{.name = "residual", .y = residual_mm, .style = Style::kBars};
  for (std::size_t i = 0; i < residual_mm.size(); ++i) bars.x.push_back(static_cast<double>(i));
  plot.series.push_back(std::move(bars));
  Series dots{.name = "error by the other points", .style = Style::kPoints};
  for (std::size_t i = 0; i < error_by_others_mm.size(); ++i) {
    if (!error_by_others_mm[i]) continue;
    dots.x.push_back(static_cast<double>(i));
    dots.y.push_back(*error_by_others_mm[i]);
  }
  if (!dots.x.empty()) plot.series.push_back(std::move(dots));
  return plot;
}

}  // namespace acus::report
