#include "benchmarks/needle_sweep.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/physics/needle/curved_path.h"
#include "acus/physics/needle/path_coupling.h"
#include "benchmarks/insertion.h"
#include "references/stiffness_fit.h"

namespace acus::benchmarks {
namespace {

using Eigen::Vector3d;

constexpr const char* kRod = "elastic rod";
constexpr double kLengthMm = 150.0;
constexpr double kBending = 51222.0;  ///< Steel of 193 GPa, 1.65 / 1.19 mm, N mm^2.
constexpr double kSeconds = 4.0;
constexpr int kSamplesPerSecond = 100;  ///< Where runs are compared: common to all step sizes.

struct NeedleSweepSetting {
  needle::RodOptions rod;
  double step_ms = 1.0;
};

NeedleSweepSetting Default() {
  NeedleSweepSetting setting;
  setting.rod.num_nodes = 25;
  return setting;
}

needle::RodModel Model(const needle::RodOptions& options) {
  needle::RodProperties properties;
  properties.length_mm = kLengthMm;
  properties.bending_n_mm2 = kBending;
  properties.twist_n_mm2 = kBending / 1.3;
  return {properties, options};
}

/// The hand at `time_s`: 20 to 80 mm deep, up to 6 mm beside its channel,
/// leaning by up to 0.1 rad.
struct Hand {
  double depth_mm = 0.0;
  needle::RodBase base;
};
Hand HandAt(double time_s) {
  Hand hand;
  hand.depth_mm = 50.0 - 30.0 * std::cos(1.5 * time_s);
  hand.base.position_mm = {6.0 * std::sin(2.1 * time_s), 4.0 * std::sin(3.3 * time_s),
                           hand.depth_mm - kLengthMm};
  hand.base.orientation = Eigen::AngleAxisd(0.1 * std::sin(2.7 * time_s), Vector3d(0.6, 0.8, 0.0));
  return hand;
}

struct NeedleRun {
  std::vector<Vector3d> force_n;  ///< On the hand, at the common times.
  std::vector<Vector3d> middle_mm;
  std::vector<double> step_us;
  double preparation_s = 0.0;
  double memory_mb = 0.0;
  int not_converged = 0;
};

double MemoryMb(const needle::RodState& state) {
  const auto bytes = [](const auto& items) { return items.size() * sizeof(items[0]); };
  return 1e-6 * static_cast<double>(bytes(state.point) + bytes(state.trial) + bytes(state.sweep) +
                                    bytes(state.action) + bytes(state.trial_action));
}

NeedleRun RunNeedle(const NeedleSweepSetting& setting) {
  const double before_s = ThreadCpuSeconds();
  const needle::RodModel model = Model(setting.rod);
  needle::RodState state = model.NewState();
  const double ready_s = ThreadCpuSeconds();
  std::vector<needle::RodContact> contacts(model.num_elements() + 2);
  needle::PathNode tissue;
  tissue.stiffness_n_per_mm2 = 0.2;
  NeedleRun run;
  run.preparation_s = ready_s - before_s;
  run.memory_mb = MemoryMb(state);
  const int steps = static_cast<int>(std::lround(1e3 * kSeconds / setting.step_ms));
  const int every =
      std::max(1, static_cast<int>(std::lround(1e3 / kSamplesPerSecond / setting.step_ms)));
  needle::CurvedPath path;
  path.Begin(tissue);
  for (int i = 0; i <= steps; ++i) {
    const Hand hand = HandAt(1e-3 * setting.step_ms * i);
    const double forward_mm = hand.depth_mm - path.LengthMm();
    forward_mm > 0.0 ? path.Advance(Vector3d::UnitZ(), forward_mm, tissue)
                     : path.Retract(-forward_mm);
    const double begin_s = ThreadCpuSeconds();
    needle::RodInput input;
    input.base = hand.base;
    const int count = needle::CoupleToPath(model, path, {}, contacts);
    input.contacts = {contacts.data(), static_cast<std::size_t>(count)};
    const needle::RodResult result = model.Solve(state, input);
    run.step_us.push_back(1e6 * (ThreadCpuSeconds() - begin_s));
    run.not_converged += !result.converged();
    if (i % every == 0) {
      run.force_n.push_back(result.base_force_n);
      run.middle_mm.push_back(model.PositionMm(state, 0.5 * kLengthMm));
    }
  }
  return run;
}

double Largest(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
  double out = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    out = std::max(out, (a[i] - b[i]).norm());
  }
  return out;
}

double Rms(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
  double sum = 0.0;
  const std::size_t count = std::min(a.size(), b.size());
  for (std::size_t i = 0; i < count; ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(count));
}

class NeedleSweeper {
 public:
  NeedleSweeper(bool quick, const RunContext& context) : quick_(quick), context_(context) {}

  std::vector<Row> Run() {
    context_.Checkpoint("reference", 0.0);
    NeedleSweepSetting fine;
    fine.rod.num_nodes = quick_ ? 201 : 401;
    fine.rod.tolerance_mm = 1e-9;
    reference_name_ = std::to_string(fine.rod.num_nodes) + " nodes, 1e-9 mm";
    reference_ = RunNeedle(fine);
    for (const int num_nodes : {8, 15, 25, 50, 100}) {
      NeedleSweepSetting setting = Default();
      setting.rod.num_nodes = num_nodes;
      Add("num_nodes", std::to_string(num_nodes), setting, num_nodes == 25);
      Cantilever(num_nodes);
    }
    for (const double tolerance_mm : {1.0, 1e-1, 1e-2, 1e-3, 1e-5}) {
      NeedleSweepSetting setting = Default();
      setting.rod.tolerance_mm = tolerance_mm;
      Add("tolerance_mm", RoundedText(tolerance_mm, 3), setting, tolerance_mm == 1e-3);
    }
    for (const int iterations : {1, 2, 4, 20}) {
      NeedleSweepSetting setting = Default();
      setting.rod.max_iterations = iterations;
      Add("max_iterations", std::to_string(iterations), setting, iterations == 20);
    }
    for (const double step_ms : {0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0}) {
      if (quick_ && step_ms < 0.5) continue;
      NeedleSweepSetting setting = Default();
      setting.step_ms = step_ms;
      Add("step_ms", RoundedText(step_ms, 3), setting, step_ms == 1.0);
    }
    return std::move(rows_);
  }

 private:
  Row NewRow(const std::string& knob, const std::string& value, bool is_default) const {
    Row row;
    row.knob = knob;
    row.value = value;
    row.model = kRod;
    row.is_default = is_default;
    return row;
  }

  void Add(const std::string& knob, const std::string& value, const NeedleSweepSetting& setting,
           bool is_default) {
    context_.Checkpoint(knob + " " + value, 0.1 + 0.04 * static_cast<double>(rows_.size()) / 3.0);
    const NeedleRun run = RunNeedle(setting);
    Row row = NewRow(knob, value, is_default);
    row.reference = reference_name_;
    row.step_us_median = math::Median(run.step_us);
    row.step_us_p999 = math::Quantile(run.step_us, 0.999);
    if (run.not_converged > 0) {
      row.unusable = Message(run.not_converged, " steps not at rest");
    }
    row.preparation_s = run.preparation_s;
    row.memory_mb = run.memory_mb;
    row.error = Rms(run.force_n, reference_.force_n);
    row.error_unit = "N";
    rows_.push_back(row);
    row.error = Largest(run.force_n, reference_.force_n);
    row.error_unit = "N, largest";
    rows_.push_back(row);
    row.error = Rms(run.middle_mm, reference_.middle_mm);
    row.error_unit = "mm";
    rows_.push_back(std::move(row));
  }

  /// 1 N across at the tip, from the straight needle; its limit for many nodes is the elastica's,
  /// by the tests of needle/rod.h.
  void Cantilever(int num_nodes) {
    Row row = NewRow("num_nodes", std::to_string(num_nodes), num_nodes == 25);
    const double exact_mm = needle::TipDeflectionMm(1.0, kLengthMm, kBending, quick_ ? 801 : 3201);
    const needle::RodLoad load{kLengthMm, {1.0, 0.0, 0.0}};
    needle::RodInput input;
    input.loads = {&load, 1};
    std::vector<double> times_us;
    for (int i = 0; i < 21; ++i) {
      const double before_s = ThreadCpuSeconds();
      needle::RodOptions options;
      options.num_nodes = num_nodes;
      const needle::RodModel model = Model(options);
      needle::RodState state = model.NewState();
      const double ready_s = ThreadCpuSeconds();
      model.Solve(state, input);
      times_us.push_back(1e6 * (ThreadCpuSeconds() - ready_s));
      row.error = 100.0 * std::abs(state.point.back().position_mm.x() / exact_mm - 1.0);
      row.preparation_s = ready_s - before_s;
      row.memory_mb = MemoryMb(state);
    }
    row.error_unit = "%";
    row.reference = "cantilever, 1 N, at once: many nodes";
    row.step_us_median = math::Median(times_us);
    row.step_us_p999 = math::Quantile(times_us, 0.999);
    rows_.push_back(std::move(row));
  }

  bool quick_;
  const RunContext& context_;
  std::string reference_name_;
  NeedleRun reference_;
  std::vector<Row> rows_;
};

}  // namespace

Sweep NeedleSweep() {
  return {
      "needle", "The bendable needle",
      "A 16-gauge needle of 150 mm goes in and out of tissue of 0.2 N/mm^2 "
      "for 4 s, its hub up "
      "to 6 mm beside the channel and leaning by up to 0.1 rad. Errors: "
      "RMS and largest "
      "of the force on the hand, and RMS of the needle's middle.",
      [](bool quick, const RunContext& context) { return NeedleSweeper(quick, context).Run(); }};
}

}  // namespace acus::benchmarks
