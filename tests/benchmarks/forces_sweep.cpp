#include "benchmarks/forces_sweep.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acus/base/config/json_file.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/physics/forces/laws/force_table.h"
#include "benchmarks/force_model_cases.h"
#include "benchmarks/friction_integration.h"
#include "benchmarks/insertion.h"

namespace acus::benchmarks {
namespace {

constexpr double kReferenceMs = 0.0625;
constexpr const char* kLargest = "N, largest";
constexpr const char* kFriction = "friction";

class ForcesSweeper {
 public:
  ForcesSweeper(bool quick, const RunContext& context) : quick_(quick), context_(context) {}

  std::vector<Row> Run() {
    context_.Checkpoint("friction", 0.0);
    const forces::LuGreParameters printed =
        forces::ReadForceTable(config::FindConfig("forces/alamilla.json", ".")).alamilla.friction;
    Friction(kFriction, printed);
    forces::LuGreParameters swapped = printed;
    std::swap(swapped.mu_coulomb, swapped.mu_static);
    Friction("friction, Stribeck", swapped);
    Models();
    return std::move(rows_);
  }

 private:
  std::vector<double> Steps() const {
    return quick_ ? std::vector<double>{0.5, 1.0, 2.0, 10.0}
                  : std::vector<double>{0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0};
  }
  int Repeats() const { return quick_ ? 1 : 3; }

  /// Two rows of one setting: RMS and largest difference.
  void Add(Row row, const ForceDifference& off) {
    row.error = off.rms_n;
    row.error_unit = "N";
    rows_.push_back(row);
    row.error = off.largest_n;
    row.error_unit = kLargest;
    rows_.push_back(std::move(row));
  }

  void Friction(const std::string& knob, const forces::LuGreParameters& law) {
    const FrictionRun reference = ReferenceFriction(law);
    double bound_n = 0.0;
    for (const double force_n : reference.force_n) {
      bound_n = std::max(bound_n, 2.0 * std::abs(force_n));
    }
    for (const FrictionMethod method : kFrictionMethods) {
      for (const double step_ms : Steps()) {
        std::vector<double> times_us;
        FrictionRun run;
        for (int i = 0; i < Repeats(); ++i) {
          run = RunFriction(law, method, step_ms);
          times_us.insert(times_us.end(), run.step_us.begin(), run.step_us.end());
        }
        Row row;
        row.knob = knob + ", " + std::string(NameOf(method)) + ": step_ms";
        row.value = RoundedText(step_ms, 3);
        row.model = "LuGre";
        row.reference = "Runge-Kutta 4, 5 us";
        row.step_us_median = math::Median(times_us);
        row.step_us_p999 = math::Quantile(times_us, 0.999);
        row.is_default = method == FrictionMethod::kShipped && step_ms == 1.0 && knob == kFriction;
        ForceDifference off;
        double sum = 0.0;
        for (std::size_t n = 0; n < run.force_n.size(); ++n) {
          const double off_n = std::abs(run.force_n[n] - reference.force_n[n]);
          sum += off_n * off_n;
          off.largest_n = std::max(off.largest_n, off_n);
          if (!(std::abs(run.force_n[n]) <= bound_n)) {
            row.unusable = "friction of over twice the largest of the law: unstable";
          }
        }
        off.rms_n = std::sqrt(sum / static_cast<double>(run.force_n.size()));
        Add(std::move(row), off);
      }
    }
  }

  void Models() {
    ForceModelOptions options;
    options.element_mm = quick_ ? 6.0 : 4.0;
    const std::vector<ForceModelCase> models = ForceModelCases(options, context_);
    std::vector<SampledRun> at_default;
    for (std::size_t i = 0; i < models.size(); ++i) {
      context_.Checkpoint(models[i].name,
                          0.2 + 0.8 * static_cast<double>(i) / static_cast<double>(models.size()));
      at_default.push_back(StepSizes(models[i]));
    }
    const auto is_fe = [](const ForceModelCase& model) { return model.name == "fe_3d"; };
    const auto fe = std::ranges::find_if(models, is_fe) - models.begin();
    for (std::size_t i = 0; i < models.size(); ++i) {
      Row row = RowOf(models[i], at_default[i]);
      row.knob = "model";
      row.value = models[i].name;
      row.reference = "fe_3d";
      row.is_default = models[i].name == "layered";
      row.is_paper =
          models[i].name == "alamilla" || models[i].name == "vidal" || models[i].name == "springs";
      Add(std::move(row), Difference(at_default[i], at_default[static_cast<std::size_t>(fe)], 1.0));
    }
  }

  Row RowOf(const ForceModelCase& model, const SampledRun& run) const {
    Row row;
    row.model = model.full_name;
    row.step_us_median = math::Median(run.step_us);
    row.step_us_p999 = math::Quantile(run.step_us, 0.999);
    row.preparation_s = model.preparation_s;
    row.memory_mb = model.memory_mb;
    row.unusable = WhyUnusable(run, model.largest_n);
    return row;
  }

  /// @return the run at 1 ms.
  SampledRun StepSizes(const ForceModelCase& model) {
    const SampledRun reference = model.run(SamplesEvery(kReferenceMs));
    SampledRun out;
    for (const double step_ms : Steps()) {
      const auto samples = SamplesEvery(step_ms);
      SampledRun run = model.run(samples);
      for (int i = 1; i < Repeats(); ++i) {
        const SampledRun again = model.run(samples);
        run.step_us.insert(run.step_us.end(), again.step_us.begin(), again.step_us.end());
      }
      Row row = RowOf(model, run);
      row.knob = model.name + ": step_ms";
      row.value = RoundedText(step_ms, 3);
      row.reference = "the same at 1/16 ms";
      row.is_default = step_ms == 1.0;
      Add(std::move(row), Difference(run, reference, step_ms));
      if (step_ms == 1.0) out = std::move(run);
    }
    return out;
  }

  bool quick_;
  const RunContext& context_;
  std::vector<Row> rows_;
};

}  // namespace

Sweep ForcesSweep() {
  return {
      "forces", "The forces on the needle",
      "Friction: LuGre in a shaft rubbed to and fro at up to 0.21 m/s, with a normal force of 1 N; "
      "the coefficients of Alamilla-2021 as printed, and with static and Coulomb swapped "
      "(Stribeck). "
      "Models: 46 mm into skin, fat, muscle and liver and out again in 7.5 s, with a stop, a push "
      "aside, and a stroke in the channel. Errors are root mean squares over moments 10 ms apart "
      "and the largest of them, but for those within two steps of an event.",
      [](bool quick, const RunContext& context) { return ForcesSweeper(quick, context).Run(); }};
}

}  // namespace acus::benchmarks
