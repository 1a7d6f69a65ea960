// Draws force over depth of several replays of one session in one plot:
//   force_depth_figure OUT.svg NAME=RUN_FOLDER...
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/report/svg_plot.h"

namespace {

/// From the skin to the greatest depth.
acus::report::Series Insertion(const std::string& name, const std::filesystem::path& run) {
  const acus::CsvTable table(run / "forces.csv");
  const std::vector<double> depth_mm = table.Numbers("depth_mm");
  const std::vector<double> force_n = table.Numbers("force_axial_n");
  const auto deepest = std::ranges::max_element(depth_mm) - depth_mm.begin();
  acus::report::Series series;
  series.name = name;
  for (std::ptrdiff_t i = 0; i <= deepest; ++i) {
    const auto n = static_cast<std::size_t>(i);
    if (depth_mm[n] <= 0.0) continue;
    series.x.push_back(depth_mm[n]);
    series.y.push_back(force_n[n]);
  }
  return series;
}

/// Where the tissue changes, by the first run that says so.
std::vector<acus::report::Span> Tissues(const std::filesystem::path& run) {
  const acus::CsvTable table(run / "forces.csv");
  const std::vector<double> depth_mm = table.Numbers("depth_mm");
  const std::vector<std::string> tissue = table.Texts("tissue");
  std::vector<acus::report::Span> spans;
  double deepest_mm = 0.0;
  for (std::size_t i = 0; i < depth_mm.size(); ++i) {
    if (depth_mm[i] <= deepest_mm || tissue[i] == "outside") continue;
    deepest_mm = depth_mm[i];
    if (spans.empty() || spans.back().text != tissue[i]) {
      spans.push_back({deepest_mm, deepest_mm, tissue[i]});
    }
    spans.back().to_x = deepest_mm;
  }
  return spans;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::cerr << "usage: force_depth_figure OUT.svg NAME=RUN_FOLDER...\n";
    return 2;
  }
  try {
    acus::report::Plot plot;
    plot.title = "Force on the needle over depth, by tissue model";
    plot.x_label = "depth [mm]";
    plot.y_label = "axial force [N]";
    plot.height_px = 420;
    for (int i = 2; i < argc; ++i) {
      const std::string argument = argv[i];
      const auto equals = argument.find('=');
      const std::string run = argument.substr(equals + 1);
      if (i == 2) plot.spans = Tissues(run);
      plot.series.push_back(Insertion(argument.substr(0, equals), run));
    }
    acus::report::WriteSvg(argv[1], plot);
  } catch (const std::exception& error) {
    std::cerr << "force_depth_figure: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
