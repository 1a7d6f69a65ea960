#include "acus/run/replay/patient_range.h"

#include <algorithm>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/data/session/pose_csv.h"
#include "acus/run/replay/force_meter.h"
#include "acus/scene/simulation/scene.h"

namespace acus::replay {
namespace {

namespace fs = std::filesystem;

constexpr double kLow = 0.05, kHigh = 0.95;

/// The scenario without anything that only images show.
scenario::Scenario WithoutImages(scenario::Scenario scenario) {
  scenario.ultrasound.reset();
  scenario.ct_slice.reset();
  std::erase_if(scenario.listed, [](const auto& called) { return !called.step(); });
  return scenario;
}

/// Force along the needle at each step, N.
std::vector<double> AxialForces(const StepLog& log) {
  std::vector<double> force_n;
  force_n.reserve(log.steps.size());
  for (const simulation::StepOutput& step : log.steps) force_n.push_back(step.force.AxialN());
  return force_n;
}

/// @param forces_n  By patient and step.
void AddQuantiles(const std::vector<std::vector<double>>& forces_n, PatientRange& range) {
  if (forces_n.empty()) return;
  std::vector<double> of_step(forces_n.size());
  for (std::size_t step = 0; step < forces_n.front().size(); ++step) {
    for (std::size_t n = 0; n < forces_n.size(); ++n) of_step[n] = forces_n[n][step];
    range.p5_n.push_back(math::Quantile(of_step, kLow));
    range.median_n.push_back(math::Quantile(of_step, 0.5));
    range.p95_n.push_back(math::Quantile(of_step, kHigh));
  }
}

/// "largest axial force" in N: "largest_axial_force_n".
std::string ColumnOf(const Metric& metric) {
  std::string name = metric.unit.empty() ? metric.name : Message(metric.name, " ", metric.unit);
  for (char& c : name) {
    if (c == ' ') c = '_';
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return name;
}

}  // namespace

PatientRange RangeOverPatients(const scenario::Scenario& scenario, const session::Session& session,
                               const simulation::AvailableInputs& available,
                               const RunContext& context) {
  scenario::Scenario other = WithoutImages(scenario);
  const simulation::EffectPlan plan = simulation::PlanEffects(other, available);
  RunContext silent = context;  // All that it would report was reported for the scenario's patient.
  silent.on_warning = nullptr;
  silent.on_progress = nullptr;
  PatientRange range;
  std::vector<std::vector<double>> forces_n;
  const auto count = static_cast<std::size_t>(scenario.patient.num_others);
  for (std::uint64_t seed = 1; range.patients.size() < count; ++seed) {
    if (seed == scenario.patient.stiffness_seed) continue;
    context.Checkpoint("other patients",
                       static_cast<double>(range.patients.size()) / static_cast<double>(count));
    other.patient.stiffness_seed = seed;
    const simulation::Scene scene = simulation::LoadScene(other, plan, silent);
    const StepLog log = RunSteps(scene, session, {}, nullptr, silent);
    ForceMeter meter;
    for (const simulation::StepOutput& step : log.steps) meter.Add(step);
    range.patients.push_back({seed, meter.Metrics(scene)});
    forces_n.push_back(AxialForces(log));
  }
  AddQuantiles(forces_n, range);
  return range;
}

void WriteRange(const fs::path& folder, const PatientRange& range, const StepLog& log) {
  std::string text = "seed";
  for (const Metric& metric : range.patients.front().metrics) text += ',' + ColumnOf(metric);
  text += '\n';
  for (const PatientRange::Patient& patient : range.patients) {
    text += std::to_string(patient.seed);
    for (const Metric& metric : patient.metrics) text += ',' + NumberText(metric.value);
    text += '\n';
  }
  WriteTextFile(folder / "other_patients.csv", text);
  text = "time_s,force_axial_p5_n,force_axial_median_n,force_axial_p95_n\n";
  for (std::size_t i = 0; i < range.median_n.size(); ++i) {
    text += session::SecondsText(log.steps[i].time_ns) + ',' + NumberText(range.p5_n[i]) + ',' +
            NumberText(range.median_n[i]) + ',' + NumberText(range.p95_n[i]) + '\n';
  }
  WriteTextFile(folder / "other_patients_range.csv", text);
}

report::Plot RangePlot(const PatientRange& range, const StepLog& log) {
  report::Series band{.name = "5 to 95 % of the other patients", .style = report::Style::kBand};
  band.low = range.p5_n;
  band.high = range.p95_n;
  report::Series median{.name = "their median"};
  median.y = range.median_n;
  median.dashed = true;
  report::Series own{.name = "this patient"};
  own.y = AxialForces(log);
  for (const simulation::StepOutput& step : log.steps) {
    own.x.push_back(1e-9 * static_cast<double>(step.time_ns - log.steps.front().time_ns));
  }
  band.x = median.x = own.x;
  report::Plot plot;
  plot.title = "Force along the needle in this patient and in others";
  plot.x_label = "time [s]";
  plot.y_label = "force [N]";
  plot.series = {std::move(band), std::move(median), std::move(own)};
  return plot;
}

RangeTable TableOf(const PatientRange& range, const std::vector<Metric>& of_this) {
  RangeTable table{{"metric", "this patient", "5 % of the others", "median", "95 %", "unit"}, {}};
  const auto text = [](double value) { return RoundedText(value, 4); };
  const std::size_t count = range.patients.front().metrics.size();
  for (std::size_t n = 0; n < count; ++n) {
    const Metric& metric = range.patients.front().metrics[n];
    std::vector<double> values;
    for (const PatientRange::Patient& patient : range.patients) {
      values.push_back(patient.metrics[n].value);
    }
    if (std::ranges::min(values) == std::ranges::max(values)) continue;  // The same in all.
    const auto own = std::ranges::find(of_this, metric.name, &Metric::name);
    table.rows.push_back({metric.name, own == of_this.end() ? "-" : text(own->value),
                          text(math::Quantile(values, kLow)), text(math::Quantile(values, 0.5)),
                          text(math::Quantile(values, kHigh)), metric.unit});
  }
  return table;
}

}  // namespace acus::replay
