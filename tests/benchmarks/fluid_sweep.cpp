#include "benchmarks/fluid_sweep.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acus/base/config/json_file.h"
#include "acus/base/core/cpu_time.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/physics/fluid/fluid_model.h"

namespace acus::benchmarks {
namespace {

constexpr double kFluidSeconds = 3.0;
constexpr double kCompareEveryMs = 4.0;

struct FluidSetting {
  int num_shells = 8;
  double step_ms = 1.0;
  bool has_friction = true;
};

struct FluidRun {
  std::vector<double> syringe_kpa;  ///< At the common times.
  double injected_ml = 0.0;
  std::vector<double> step_us;
};

/// 1 s of pressure in the ligament, 0.5 s in which the bevel passes, then the epidural space.
fluid::FluidInput FluidInputAt(double time_s, int ligament, int epidural) {
  fluid::FluidInput input;
  input.hand_n = 10.0 * std::min(1.0, time_s / 0.1);
  input.coupling_n_s_per_mm = 0.5;
  const double share = std::clamp(2.0 * (time_s - 1.0), 0.0, 1.0);
  input.bevel = {{{ligament, 1.0 - share}, {epidural, share}}};
  input.heart_cycles = 1.2 * time_s;
  return input;
}

FluidRun RunFluid(const FluidSetting& setting) {
  const fluid::FluidTable table =
      fluid::ReadFluidTable(config::FindConfig("fluid/default.json", "."));
  fluid::Syringe syringe = table.SyringeNamed("lor_glass_10ml");
  if (!setting.has_friction) syringe.static_friction_n = syringe.sliding_friction_n = 0.0;
  fluid::FluidOptions options;
  options.num_shells = setting.num_shells;
  const fluid::FluidModel model(table, syringe, {6.0, 0.1},
                                {.inner_diameter_mm = 1.194, .length_mm = 80.0}, options);
  const int ligament = table.TissueIndex("ligament");
  const int epidural = table.TissueIndex("epidural_lumbar");
  fluid::FluidState state = model.NewState();
  const auto num = static_cast<int>(std::lround(1e3 * kFluidSeconds / setting.step_ms));
  const auto every = static_cast<int>(std::lround(kCompareEveryMs / setting.step_ms));
  FluidRun run;
  double begin_s = ThreadCpuSeconds();
  for (int n = 1; n <= num; ++n) {
    const double time_s = 1e-3 * setting.step_ms * n;
    const fluid::FluidOutput output =
        model.Step(state, FluidInputAt(time_s, ligament, epidural), 1e-3 * setting.step_ms);
    if (n % every != 0) continue;
    run.syringe_kpa.push_back(output.syringe_kpa);
    run.step_us.push_back(1e6 * (ThreadCpuSeconds() - begin_s) / every);
    begin_s = ThreadCpuSeconds();
  }
  run.injected_ml = state.tissue[static_cast<std::size_t>(epidural)].liquid_ml;
  return run;
}

double FluidRms(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

std::vector<Row> RunFluidSweep(bool quick, const RunContext& context) {
  context.Checkpoint("reference", 0.0);
  const double finest_ms = quick ? 0.1 : 0.02;
  const FluidRun references[] = {RunFluid({fluid::kMaxShells, finest_ms, false}),
                                 RunFluid({fluid::kMaxShells, finest_ms})};
  std::vector<Row> rows;
  const auto add = [&](const std::string& knob, const std::string& value,
                       const FluidSetting& setting, bool is_default) {
    const FluidRun run = RunFluid(setting);
    const FluidRun& reference = references[setting.has_friction ? 1 : 0];
    Row row;
    row.knob = knob;
    row.value = value;
    row.model = "fluid";
    row.is_default = is_default;
    row.reference = quick ? "32 shells, 0.1 ms" : "32 shells, 0.02 ms";
    row.step_us_median = math::Median(run.step_us);
    row.step_us_p999 = math::Quantile(run.step_us, 0.999);
    row.error = FluidRms(run.syringe_kpa, reference.syringe_kpa);
    row.error_unit = "kPa";
    rows.push_back(row);
    row.error = 1e3 * std::abs(run.injected_ml - reference.injected_ml);
    row.error_unit = "ul";
    rows.push_back(std::move(row));
  };
  for (const int num_shells : {2, 4, 8, 16, 32}) {
    add("num_shells", std::to_string(num_shells), {num_shells, 1.0}, num_shells == 8);
  }
  for (const double step_ms : {0.25, 0.5, 1.0, 2.0, 4.0}) {
    add("step_ms", RoundedText(step_ms, 3), {8, step_ms}, step_ms == 1.0);
  }
  for (const double step_ms : {0.25, 1.0, 4.0}) {
    add("step_ms, no friction", RoundedText(step_ms, 3), {32, step_ms, false}, false);
  }
  return rows;
}

}  // namespace

Sweep FluidSweep() {
  return {"fluid", "Fluid through the needle",
          "A loss of resistance: a thumb of 10 N on a syringe of saline with a bubble, 1 s in the "
          "yellow ligament, 0.5 s in which the bevel passes into the epidural space, 1.5 s there. "
          "Errors: RMS of the pressure in the syringe over all times, and of the injected volume.",
          RunFluidSweep};
}

}  // namespace acus::benchmarks
