#include "benchmarks/strain_sweep.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "benchmarks/tissue_run.h"

namespace acus::benchmarks {
namespace {

constexpr double kStrainElementMm = 4.0;    ///< acus-mesh: corridor/element_size_mm.
constexpr double kStrainCorridorMm = 10.0;  ///< Of scenarios.
constexpr double kStrainReachMm = 14.0;     ///< Of the condensation: elements must lie in it whole.
constexpr double kQuickElementMm = 6.0;
constexpr double kPunctureN = 0.3;  ///< In one sample: 0.02 mm.
constexpr int kSettledIterations = 30;

/// Of an insertion with the region's law.
struct StrainKnobs {
  double element_mm = 0.0;  ///< 0: as all others of the sweep.
  int nodes = tissue::StrainSettings().max_nodes;
  int iterations = tissue::StrainSettings().iterations;
  bool stiffens = true;
};

class StrainSweeper {
 public:
  StrainSweeper(bool quick, const RunContext& context)
      : quick_(quick),
        context_(context),
        provenance_(context.provenance),
        tables_(TissueBlockTables::FromPresets(provenance_)),
        samples_(ScriptedInsertion()) {}

  std::vector<Row> Run() {
    const int most_nodes = quick_ ? 120 : tissue::StrainSettings::kMostNodes;
    const MeasuredRun best = Insertion({.nodes = most_nodes, .iterations = kSettledIterations});
    const MeasuredRun usual = Insertion({});
    const std::string of_best = std::to_string(most_nodes) + " nodes, settled";
    Add("law", "linear", Insertion({.stiffens = false}), best, of_best);
    Add("law", "finite_strain", usual, best, of_best);
    for (const int nodes : quick_ ? std::vector{30, 120} : std::vector{40, 80, 160, 240, 400}) {
      const bool is_usual = nodes == StrainKnobs().nodes;
      Add("strain_nodes", std::to_string(nodes), is_usual ? usual : Insertion({.nodes = nodes}),
          best, of_best);
    }
    const int nodes = quick_ ? most_nodes : StrainKnobs().nodes;
    const MeasuredRun settled = Insertion({.nodes = nodes, .iterations = kSettledIterations});
    for (const int iterations : quick_ ? std::vector{1, kSettledIterations}
                                       : std::vector{1, 2, 3, 6, kSettledIterations}) {
      Add("strain_iterations", std::to_string(iterations),
          iterations == kSettledIterations ? settled
                                           : Insertion({.nodes = nodes, .iterations = iterations}),
          settled, std::to_string(kSettledIterations) + " iterations");
    }
    Elements(most_nodes);
    return std::move(rows_);
  }

 private:
  MeasuredRun Insertion(const StrainKnobs& knobs) const {
    context_.Checkpoint(
        std::to_string(knobs.nodes) + " nodes, " + std::to_string(knobs.iterations) + " iterations",
        static_cast<double>(rows_.size()) / 34.0);
    RunContext quiet;
    quiet.stop = context_.stop;
    quiet.num_threads = context_.num_threads;
    FemSetting setting;
    setting.element_mm = knobs.element_mm > 0.0 ? knobs.element_mm
                         : quick_               ? kQuickElementMm
                                                : kStrainElementMm;
    setting.corridor_radius_mm = kStrainReachMm;
    if (knobs.stiffens) {
      setting.strain.emplace();
      setting.strain->corridor = WayOf(samples_, kStrainCorridorMm);
      setting.strain->max_nodes = knobs.nodes;
      setting.strain->iterations = knobs.iterations;
    }
    return RunFem(setting, tables_, samples_, quiet);
  }

  /// With as many nodes as a region may have, of elements that leave a region; the finest elements
  /// are the reference.
  void Elements(int most_nodes) {
    std::vector<std::pair<double, MeasuredRun>> runs;
    for (const double size_mm : quick_ ? std::vector{6.0, 4.0} : std::vector{6.0, 4.0, 3.0}) {
      runs.emplace_back(size_mm, Insertion({.element_mm = size_mm, .nodes = most_nodes}));
    }
    for (const auto& [size_mm, run] : runs) {
      Add("strain, element_size_mm", RoundedText(size_mm, 3), run, runs.back().second,
          "elements of " + RoundedText(runs.back().first, 3) + " mm");
    }
  }

  /// Depths of the tip where a membrane gives way on the way in: where the force falls, mm.
  std::vector<double> PuncturesMm(const InsertionRun& run) const {
    std::vector<double> depths_mm;
    double before_mm = 0.0;
    for (std::size_t n = 1; n < run.force_n.size(); ++n) {
      const double depth_mm = samples_[n].tip_in_ct_mm[2] / samples_[n].axis_in_ct[2];
      if (depth_mm <= before_mm) continue;  // Not on the way out.
      before_mm = depth_mm;
      if (run.force_n[n - 1].norm() - run.force_n[n].norm() < kPunctureN) continue;
      if (depths_mm.empty() || depth_mm > depths_mm.back() + 1.0) depths_mm.push_back(depth_mm);
    }
    return depths_mm;
  }

  /// Of the puncture that is farthest from that of the other run; not measured if there are more.
  double PunctureErrorMm(const InsertionRun& run, const InsertionRun& reference) const {
    const std::vector<double> here = PuncturesMm(run);
    const std::vector<double> there = PuncturesMm(reference);
    if (here.empty() || here.size() != there.size()) return kNotMeasured;
    double largest_mm = 0.0;
    for (std::size_t n = 0; n < here.size(); ++n) {
      largest_mm = std::max(largest_mm, std::abs(here[n] - there[n]));
    }
    return largest_mm;
  }

  void Add(const std::string& knob, const std::string& value, const MeasuredRun& run,
           const MeasuredRun& reference, const std::string& what) {
    const bool is_default =
        knob == "law" ? value == "linear"
                      : value == defaults_.at(knob) && (!quick_ || knob == "strain_iterations");
    Row row;
    row.knob = knob;
    row.value = value;
    row.model = "3D finite elements";
    row.reference = what;
    row.step_us_median = math::Median(run.run.step_us);
    row.step_us_p999 = math::Quantile(run.run.step_us, 0.999);
    row.preparation_s = run.preparation_s;
    row.memory_mb = run.memory_mb;
    row.is_default = is_default;
    row.unusable = WhyUnusable(run.run, samples_, tables_.forces.settings.largest_force_n);
    row.error = RmsDifferenceN(run.run, reference.run);
    row.error_unit = "N";
    rows_.push_back(row);
    row.error = PunctureErrorMm(run.run, reference.run);
    row.error_unit = "mm";
    rows_.push_back(std::move(row));
  }

  std::map<std::string, std::string> defaults_{
      {"strain_nodes", std::to_string(StrainKnobs().nodes)},
      {"strain_iterations", std::to_string(StrainKnobs().iterations)},
      {"strain, element_size_mm", RoundedText(kStrainElementMm, 3)}};
  bool quick_;
  const RunContext& context_;
  Provenance provenance_;
  TissueBlockTables tables_;
  std::vector<tissue::ToolSample> samples_;
  std::vector<Row> rows_;
};

}  // namespace

Sweep StrainSweep() {
  return {
      "strain", "Tissue at large strain under the needle",
      "The insertion of the sweep tissue into 3D finite elements that follow the laws of the "
      "elasticity table in a region around the needle. Errors are root mean squares over all "
      "samples of the difference of forces, N, and by how much the skin is punctured elsewhere, "
      "mm.",
      [](bool quick, const RunContext& context) { return StrainSweeper(quick, context).Run(); }};
}

}  // namespace acus::benchmarks
