// Repeats the upper half of figure 5 of Fortmeier-2016: fortmeier_figure_5 OUT.svg
#include <iostream>

#include "acus/base/report/svg_plot.h"
#include "support/fortmeier_liver.h"

namespace {

void Draw(const std::filesystem::path& file) {
  using namespace acus;  // NOLINT: a program may.
  testing_support::FortmeierAsPrinted printed;
  const tissue::SpringModel model = testing_support::FortmeierSprings();
  tissue::SpringState state = model.NewState();
  report::Series as_printed{.name = "algorithm 1 as printed"};
  report::Series springs{.name = "springs of lib/tissue"};
  double time_s = 0.0;
  for (const double depth_mm : testing_support::FortmeierMotionMm()) {
    tissue::ToolSample sample;
    sample.time_s = time_s += 0.001;
    sample.tip_in_ct_mm.z() = depth_mm;
    as_printed.x.push_back(depth_mm);
    as_printed.y.push_back(printed.Step(depth_mm));
    springs.x.push_back(depth_mm);
    springs.y.push_back(model.Step(state, sample).AxialN());
  }
  report::Plot plot;
  plot.title = "Into bovine liver, a pause at 40 mm, and out";
  plot.x_label = "insertion depth [mm]";
  plot.y_label = "force against insertion [N]";
  plot.series = {as_printed, springs};
  WriteSvg(file, plot);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: fortmeier_figure_5 OUT.svg\n";
    return 2;
  }
  try {
    Draw(argv[1]);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
