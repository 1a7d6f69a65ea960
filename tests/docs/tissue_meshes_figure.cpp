// Draws force over depth in the layered block with elements of h, h/2 and h/4:
//   tissue_meshes_figure OUT.svg
#include <algorithm>
#include <iostream>
#include <string>
#include <vector>

#include "acus/base/core/text_table.h"
#include "acus/base/report/svg_plot.h"
#include "benchmarks/tissue_run.h"

namespace {

using acus::tissue::ToolSample;

/// Of the insertion, from the skin to the greatest depth.
acus::report::Series Insertion(double element_mm, const std::vector<ToolSample>& samples,
                               const acus::benchmarks::TissueBlockTables& tables) {
  const acus::benchmarks::MeasuredRun measured =
      acus::benchmarks::RunFem({.element_mm = element_mm}, tables, samples, {});
  acus::report::Series series{.name = "elements of " + acus::FixedText(element_mm, 0) + " mm"};
  double deepest_mm = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double depth_mm = -samples[i].tip_in_ct_mm.z();
    if (depth_mm <= deepest_mm) continue;
    deepest_mm = depth_mm;
    series.x.push_back(depth_mm);
    series.y.push_back(-measured.run.force_n[i].dot(samples[i].axis_in_ct.normalized()));
  }
  return series;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: tissue_meshes_figure OUT.svg\n";
    return 2;
  }
  try {
    acus::Provenance provenance;
    const auto tables = acus::benchmarks::TissueBlockTables::FromPresets(provenance);
    const std::vector<ToolSample> samples = acus::benchmarks::ScriptedInsertion();
    acus::report::Plot plot{.title = "Force on the needle by the size of the elements",
                            .x_label = "depth of the device's tip below the skin at rest [mm]",
                            .y_label = "axial force [N]"};
    plot.height_px = 420;
    for (const double element_mm : {8.0, 4.0, 2.0}) {
      plot.series.push_back(Insertion(element_mm, samples, tables));
    }
    acus::report::WriteSvg(argv[1], plot);
  } catch (const std::exception& error) {
    std::cerr << "tissue_meshes_figure: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
