#include "acus/assess/tuning/scene_sweep.h"

#include <algorithm>
#include <functional>
#include <set>

#include "acus/base/core/error.h"
#include "acus/base/core/machine.h"
#include "acus/base/core/spelling.h"

namespace acus::tuning {
namespace {

namespace fs = std::filesystem;

const Case& CaseNamed(const SweepPlan& plan, const std::string& name) {
  const auto found = std::ranges::find(plan.cases, name, &Case::name);
  if (found != plan.cases.end()) return *found;
  std::vector<std::string> names;
  for (const Case& one : plan.cases) names.push_back(one.name);
  const auto nearest = NearestSpelling(name, names);
  throw InputError(Message("--case ", name, ": there is no such case",
                           nearest ? "; did you mean " + *nearest + "?" : ".",
                           " --list prints all ", names.size()));
}

/// Runs one case and stores it; makes its reference first if that does not exist.
Measured RunOne(const SweepPlan& plan, const Case& one, const RunStore& store,
                RunContext& context) {
  const fs::path reference_file = store.ReferenceFile(one.reference);
  std::optional<Series> reference;
  if (!one.is_reference) {
    reference = ReadSeries(reference_file);
    if (!reference) {
      RunOne(plan, CaseNamed(plan, one.reference_case), store, context);
      reference = ReadSeries(reference_file);
      ACUS_REQUIRE(reference, reference_file.string(), ": cannot be read back; is the disk full?");
    }
  }
  CaseRun run = RunSetting(plan, one.setting, one.repetition, context);
  run.measured.knob = one.knob;
  run.measured.is_reference = SameValue(one.setting, one.reference_setting);
  Compare(run.series, reference ? *reference : run.series,
          AroundEventS(plan, one.setting, one.reference_setting), run.measured);
  // The series first: a stored run implies that its reference exists.
  if (one.is_reference) WriteSeries(reference_file, run.series);
  store.Keep(one.name, run.measured);
  return run.measured;
}

/// A context whose progress is that of the whole sweep, and that prints each warning once.
class SweepContext {
 public:
  explicit SweepContext(RunContext& context) : outer_(context), inner_(context) {
    inner_.on_progress = [this](std::string_view, double fraction) {
      // Steps, images and repeated steps each count from 0 to 1.
      if (fraction < last_) part_ = std::min(part_ + 1.0, kParts - 1.0);
      last_ = std::clamp(fraction, 0.0, 1.0);
      outer_.Checkpoint(task_, (done_ + (part_ + last_) / kParts) / std::max(1, count_));
    };
    inner_.on_warning = [this](std::string_view text) {
      if (warned_.insert(std::string(text)).second) outer_.Warn(text);
    };
  }
  ~SweepContext() { outer_.provenance = inner_.provenance; }
  SweepContext(const SweepContext&) = delete;
  SweepContext& operator=(const SweepContext&) = delete;

  void Begin(std::string task, int done, int count) {
    task_ = std::move(task);
    done_ = done;
    count_ = count;
    part_ = last_ = 0.0;
    outer_.Checkpoint(task_, static_cast<double>(done) / std::max(1, count));
  }
  RunContext& inner() { return inner_; }

 private:
  RunContext& outer_;
  RunContext inner_;
  std::string task_;
  int done_ = 0;
  int count_ = 0;
  static constexpr double kParts = 3.0;  // Phases of a run.
  double part_ = 0.0;
  double last_ = 0.0;
  std::set<std::string> warned_;
};

bool IsScenarios(const Knob& knob, const nlohmann::json& value) {
  if (!knob.is_folder) return SameValue(value, knob.scenario_value);
  std::error_code ignored;
  const auto file = [](fs::path path) {
    return fs::is_directory(path) && fs::exists(path / "mesh.vtu") ? path / "mesh.vtu" : path;
  };
  return knob.scenario_value.is_string() &&
         fs::equivalent(file(ValueText(value)), file(ValueText(knob.scenario_value)), ignored);
}

/// Estimates one number from its values in all repetitions.
Estimate Over(const std::vector<const Measured*>& runs,
              const std::function<double(const Measured&)>& value) {
  std::vector<double> values;
  for (const Measured* run : runs) values.push_back(value(*run));
  return EstimateOf(values);
}

Estimate Paired(const std::vector<const Measured*>& a, const std::vector<const Measured*>& b,
                double Measured::*value) {
  std::vector<double> differences;
  for (const Measured* x : a) {
    for (const Measured* y : b) {
      if (x->repetition == y->repetition) differences.push_back(x->*value - y->*value);
    }
  }
  return EstimateOf(differences);
}

void Mark(const SweepPlan& plan, SettingResult& out) {
  out.is_scenario = true;
  for (const auto& [name, value] : out.setting) {
    const Knob& knob = KnobNamed(plan.knobs, name);
    out.is_scenario = out.is_scenario && IsScenarios(knob, value);
    if (out.setting.size() > 1) continue;
    out.is_default = !knob.default_value.is_null() && SameValue(value, knob.default_value);
    for (const PaperValue& paper : knob.papers) {
      if (!SameValue(paper.value, value)) continue;
      out.is_paper = true;
      out.paper += (out.paper.empty() ? "" : "; ") + paper.source;
    }
  }
}

SettingResult ResultOf(const SweepPlan& plan, const std::string& knob, const Setting& setting,
                       const std::vector<const Measured*>& runs) {
  SettingResult out;
  out.knob = knob;
  out.setting = setting;
  out.is_reference = runs.front()->is_reference;
  Mark(plan, out);
  for (const Measured* run : runs) {
    if (out.unusable.empty()) out.unusable = run->unusable;
  }
  out.step_us_median = Over(runs, [](const Measured& m) { return m.step_us_median; });
  out.step_us_p999 = Over(runs, [](const Measured& m) { return m.step_us_p999; });
  out.image_ms_median = Over(runs, [](const Measured& m) { return m.image_ms_median; });
  out.image_ms_p95 = Over(runs, [](const Measured& m) { return m.image_ms_p95; });
  out.preparation_s = Over(runs, [](const Measured& m) { return m.preparation_s; });
  out.memory_mb = Over(runs, [](const Measured& m) { return m.memory_mb; });
  out.force_felt_n = Over(runs, [](const Measured& m) { return m.force_felt_n; });
  out.force_rms_n = Over(runs, [](const Measured& m) { return m.force_rms_n; });
  out.force_largest_n = Over(runs, [](const Measured& m) { return m.force_largest_n; });
  out.image_rms_grey = Over(runs, [](const Measured& m) { return m.image_rms_grey; });
  out.image_psnr_db = Over(runs, [](const Measured& m) { return m.ImagePsnrDb(); });
  out.image_ssim = Over(runs, [](const Measured& m) { return m.image_ssim; });
  return out;
}

}  // namespace

CaseRun RunSetting(const SweepPlan& plan, const Setting& setting, int repetition,
                   RunContext& context) {
  RunSettings settings;
  settings.changes = OverridesOf(plan.knobs, setting);
  settings.seed = plan.request.seed + static_cast<std::uint64_t>(repetition);
  const auto rate = setting.find("step_rate_hz");
  if (rate != setting.end()) {
    // Uses the recorded samples themselves if the rate is the recorded one.
    const Knob& knob = KnobNamed(plan.knobs, "step_rate_hz");
    if (!SameValue(rate->second, knob.scenario_value)) settings.step_rate_hz = rate->second;
  }
  CaseRun run = RunCase(plan.request.scene, settings, context);
  run.measured.setting = setting;
  run.measured.repetition = repetition;
  return run;
}

double AroundEventS(const SweepPlan& plan, const Setting& a, const Setting& b) {
  const auto period_s = [&plan](const Setting& setting) {
    const auto rate = setting.find("step_rate_hz");
    return rate != setting.end() ? 1.0 / rate->second.get<double>() : 1e-3 * plan.step_period_ms;
  };
  return 2.0 * std::max(period_s(a), period_s(b));
}

Progress ProgressOf(const SweepPlan& plan, const RunStore& store) {
  Progress progress{.planned = static_cast<int>(plan.cases.size()), .done = 0};
  for (const Case& one : plan.cases) progress.done += store.Find(one.name).has_value();
  return progress;
}

void RunCases(const SweepPlan& plan, const RunStore& store, const std::string& only_case,
              RunContext& context) {
  SweepContext sweep(context);
  if (!only_case.empty()) {
    const Case& one = CaseNamed(plan, only_case);
    sweep.Begin(only_case, 0, 1);
    if (!store.Find(only_case)) RunOne(plan, one, store, sweep.inner());
    return;
  }
  const Progress before = ProgressOf(plan, store);
  const std::string task =
      before.done == 0 ? "runs" : Message("runs (", before.done, " of them were there)");
  for (int i = 0; i < before.planned; ++i) {
    sweep.Begin(task, i, before.planned);
    const Case& one = plan.cases[static_cast<std::size_t>(i)];
    // Another process may have run it in the meantime.
    if (!store.Find(one.name)) RunOne(plan, one, store, sweep.inner());
  }
  sweep.Begin(task, before.planned, before.planned);
}

std::vector<SettingResult> SettingsOf(const SweepPlan& plan, const std::vector<Measured>& runs) {
  ACUS_ASSERT(runs.size() == plan.cases.size());
  std::vector<SettingResult> results;
  std::vector<std::vector<const Measured*>> groups;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Case& one = plan.cases[i];
    if (one.repetition != 0) continue;
    std::vector<const Measured*> group;
    for (std::size_t j = 0; j < runs.size(); ++j) {
      if (plan.cases[j].knob == one.knob && plan.cases[j].setting == one.setting) {
        group.push_back(&runs[j]);
      }
    }
    results.push_back(ResultOf(plan, one.knob, one.setting, group));
    groups.push_back(std::move(group));
  }
  for (std::size_t i = 0; i < results.size(); ++i) {
    for (std::size_t j = 0; j < results.size(); ++j) {
      if (results[j].knob != results[i].knob || !results[j].is_scenario) continue;
      results[i].step_us_over_scenario = Paired(groups[i], groups[j], &Measured::step_us_median);
      results[i].image_ms_over_scenario = Paired(groups[i], groups[j], &Measured::image_ms_median);
      results[i].force_rms_over_scenario_n = Paired(groups[i], groups[j], &Measured::force_rms_n);
    }
  }
  // In the plan the most expensive comes first, as others need it; in reports it is the last.
  for (auto begin = results.begin(); begin != results.end();) {
    const auto end = std::find_if(begin, results.end(),
                                  [&](const SettingResult& r) { return r.knob != begin->knob; });
    std::rotate(begin, begin + 1, end);
    begin = end;
  }
  return results;
}

SweepResult Summarise(const SweepPlan& plan, std::vector<Measured> runs) {
  SweepResult result;
  result.scenario = plan.scenario_name;
  result.scenario_file = plan.request.scene.scenario;
  result.session = plan.request.scene.session;
  result.seconds = plan.seconds;
  result.step_period_ms = plan.step_period_ms;
  result.image_period_ms = plan.image_period_ms;
  result.machine = MachineName();
  result.jointly = plan.request.jointly;
  result.is_subset = plan.is_subset;
  result.repetitions = plan.request.repetitions;
  result.knobs = plan.knobs;
  result.settings = SettingsOf(plan, runs);
  result.runs = std::move(runs);
  return result;
}

SweepResult Collect(const SweepPlan& plan, const RunStore& store) {
  std::vector<Measured> runs;
  for (const Case& one : plan.cases) {
    if (auto run = store.Find(one.name)) runs.push_back(std::move(*run));
  }
  const std::size_t missing = plan.cases.size() - runs.size();
  ACUS_REQUIRE(missing == 0, store.folder().string(), ": ", missing, " of ", plan.cases.size(),
               " runs are missing; run the same command without --collect");
  return Summarise(plan, std::move(runs));
}

}  // namespace acus::tuning
