// The bendable needle against the paper's rigid bodies: error and time, in one run.
// Run: build/tests/bench_rod (the tables; then, unless --tables is given, Google Benchmark's list
// of steps). With --tables it fails if the rod is not ten times cheaper at the same error.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string_view>
#include <vector>

#include "acus/base/core/cpu_time.h"
#include "acus/base/math/statistics.h"
#include "acus/physics/needle/curved_path.h"
#include "acus/physics/needle/path_coupling.h"
#include "acus/physics/needle/rod.h"
#include "benchmarks/bench/bullet_chain.h"
#include "references/stiffness_fit.h"
#include "unit/physics/needle/elastica.h"

namespace acus::bench {
namespace {

using Eigen::Vector3d;
using needle::RodInput;
using needle::RodLoad;
using needle::RodModel;
using needle::RodState;

constexpr double kLengthMm = 150.0;
/// What reproduces the measured 12.5 mm and 26.0 mm (Fortmeier-2016), N mm^2.
double Bending() {
  static const double bending = [] {
    const needle::TipDeflection measured[] = {{0.5, 12.5}, {1.0, 26.0}};
    return needle::FitBendingStiffness(measured, kLengthMm);
  }();
  return bending;
}

double ThreadMicroseconds() {
  return 1e6 * ThreadCpuSeconds();
}

RodModel Rod(int num_nodes) {
  needle::RodProperties properties;
  properties.length_mm = kLengthMm;
  properties.bending_n_mm2 = Bending();
  properties.twist_n_mm2 = Bending() / 1.3;
  needle::RodOptions options;
  options.num_nodes = num_nodes;
  return {properties, options};
}

double ExactMm(double force_n) {
  const double load = force_n * kLengthMm * kLengthMm / Bending();
  return kLengthMm * needle::testing_support::Elastica(load, 0.0, load).across;
}

double PhysicalSpring(int num_nodes) {
  return 1e-6 * Bending() / (1e-3 * kLengthMm / (num_nodes - 1));
}

struct Answer {
  double tip_mm = 0.0;
  double microseconds = 0.0;  ///< From the straight needle.
  int steps = 0;
};

Answer SolveRod(int num_nodes, double force_n) {
  const RodModel model = Rod(num_nodes);
  const RodLoad load{kLengthMm, {force_n, 0.0, 0.0}};
  RodInput input;
  input.loads = {&load, 1};
  Answer answer;
  std::vector<double> times;
  for (int i = 0; i < 101; ++i) {
    RodState state = model.NewState();
    const double begin = ThreadMicroseconds();
    answer.steps = model.Solve(state, input).iterations;
    times.push_back(ThreadMicroseconds() - begin);
    answer.tip_mm = state.point.back().position_mm.x();
  }
  answer.microseconds = math::Median(times);
  return answer;
}

/// Runs the chain until it is at rest. `steps` is when it came, to stay, within 1 % of `exact_mm`;
/// 0 if it does not.
Answer SettleChain(const ChainOptions& options, double force_n, double exact_mm) {
  BulletChain chain(options);
  chain.SetTipForce(force_n);
  const double finer = std::max(1.0, (options.num_nodes - 1) / 24.0);
  const int total = static_cast<int>(2500 * finer * finer);
  Answer answer;
  const double begin = ThreadMicroseconds();
  for (int i = 1; i <= total; ++i) {
    chain.Substep();
    const bool near = std::abs(chain.TipMm() / exact_mm - 1.0) <= 0.01;
    answer.steps = near ? (answer.steps == 0 ? i : answer.steps) : 0;
  }
  answer.tip_mm = chain.TipMm();
  answer.microseconds = (ThreadMicroseconds() - begin) / total * answer.steps;
  return answer;
}

/// Fortmeier-2016, table 1, with the rod and two chains: one spring constant for all numbers of
/// nodes, as in the paper, and the spring constant that follows from the spacing.
void PrintDeflections() {
  std::printf("Tip deflection of a clamped 16-gauge needle, 150 mm, EI = %.0f N mm^2\n", Bending());
  std::printf(
      "nodes force elastica |    rod  error   time | chain, one spring | chain, EI/spacing  "
      "steps and time to 1 %%\n");
  for (const int num_nodes : {15, 25, 50, 100}) {
    for (const double force_n : {0.5, 1.0}) {
      const double exact_mm = ExactMm(force_n);
      const Answer rod = SolveRod(num_nodes, force_n);
      const Answer one = SettleChain(ScaledTo(num_nodes, PhysicalSpring(25)), force_n, exact_mm);
      const Answer own =
          SettleChain(ScaledTo(num_nodes, PhysicalSpring(num_nodes)), force_n, exact_mm);
      const auto percent = [&](double tip_mm) { return 100.0 * (tip_mm / exact_mm - 1.0); };
      std::printf(
          "%5d %4.1f N %5.2f mm | %5.2f mm %+.2f %% %4.0f us | %6.2f mm %+6.1f %% | "
          "%6.2f mm %+5.1f %%  %6d %8.0f us\n",
          num_nodes, force_n, exact_mm, rod.tip_mm, percent(rod.tip_mm), rod.microseconds,
          one.tip_mm, percent(one.tip_mm), own.tip_mm, percent(own.tip_mm), own.steps,
          own.microseconds);
    }
  }
}

/// A tip load that a hand could make: 0 to 0.5 N and back once a second, 1000 steps a second.
class Swing {
 public:
  static constexpr int kSteps = 1000;
  Swing() {
    for (int i = 0; i <= kGrid; ++i) grid_mm_[i] = ExactMm(0.5 * i / kGrid);
  }
  double ForceN(int step) const {
    return 0.25 * (1.0 - std::cos(2.0 * std::numbers::pi * step / kSteps));
  }
  double ExactTipMm(int step) const {
    const double at = ForceN(step) / 0.5 * kGrid;
    const int i = std::min(static_cast<int>(at), kGrid - 1);
    return grid_mm_[i] + (at - i) * (grid_mm_[i + 1] - grid_mm_[i]);
  }
  double PeakMm() const { return grid_mm_[kGrid]; }

 private:
  static constexpr int kGrid = 200;
  double grid_mm_[kGrid + 1];
};

struct Tracking {
  double rms_percent = 0.0;  ///< Of the peak deflection.
  double microseconds = 0.0;
};

template <typename Step>
Tracking Track(const Swing& swing, Step step) {
  for (int i = 0; i < Swing::kSteps; ++i) step(swing.ForceN(i));  // Into the rhythm.
  double sum = 0.0;
  const double begin = ThreadMicroseconds();
  for (int i = 0; i < Swing::kSteps; ++i) {
    const double off = step(swing.ForceN(i)) - swing.ExactTipMm(i);
    sum += off * off;
  }
  Tracking tracking;
  tracking.microseconds = (ThreadMicroseconds() - begin) / Swing::kSteps;
  tracking.rms_percent = 100.0 * std::sqrt(sum / Swing::kSteps) / swing.PeakMm();
  return tracking;
}

/// @return how many times more expensive than the rod a step of the chain is, brought to an error
/// of 1 % (the rod's is far below it); 0 if no number of substeps brings it there.
double PrintTracking() {
  const Swing swing;
  const RodModel model = Rod(25);
  RodState state = model.NewState();
  const Tracking rod = Track(swing, [&](double force_n) {
    const RodLoad load{kLengthMm, {force_n, 0.0, 0.0}};
    RodInput input;
    input.loads = {&load, 1};
    model.Solve(state, input);
    return state.point.back().position_mm.x();
  });
  std::printf(
      "\nTip load 0 to 0.5 N once a second, 1 kHz, 25 nodes: error (RMS of peak) and time "
      "of a step\n");
  std::printf("rod                        %6.2f %%  %8.1f us\n", rod.rms_percent, rod.microseconds);
  for (int substeps = 1; substeps <= 512; substeps *= 2) {
    BulletChain chain(ScaledTo(25, PhysicalSpring(25)));
    const Tracking tracking = Track(swing, [&](double force_n) {
      chain.SetTipForce(force_n);
      for (int i = 0; i < substeps; ++i) chain.Substep();
      return chain.TipMm();
    });
    std::printf("chain, %3d substeps a step %6.2f %%  %8.1f us  %5.1f times the rod\n", substeps,
                tracking.rms_percent, tracking.microseconds,
                tracking.microseconds / rod.microseconds);
    if (tracking.rms_percent > 1.0) continue;
    const double times = tracking.microseconds / rod.microseconds;
    std::printf("brought to 1 %%, the chain is %.0f times dearer; wanted: 10\n", times);
    return rod.rms_percent <= 1.0 ? times : 0.0;
  }
  return 0.0;
}

/// A step as in a scene: hub moved and turned by a hand, the front in tissue, 1 kHz.
class Scene {
 public:
  explicit Scene(int num_nodes)
      : model_(Rod(num_nodes)), state_(model_.NewState()), contacts_(num_nodes + 1) {
    path_.Begin(Tissue());
    path_.Advance(Vector3d::UnitZ(), 60.0, Tissue());
  }
  const needle::RodResult& Step() {
    const double t = 1e-3 * step_++;
    const double forward_mm = 0.03 * std::cos(1.3 * t);
    if (forward_mm > 0.0) {
      path_.Advance(state_.point.back().tangent, forward_mm, Tissue());
    } else {
      path_.Retract(-forward_mm);
    }
    const int count = needle::CoupleToPath(model_, path_, {}, contacts_);
    RodInput input;
    input.contacts = {contacts_.data(), static_cast<std::size_t>(count)};
    input.base.position_mm = {4.0 * std::sin(3.0 * t), 5.0 * std::sin(2.1 * t),
                              path_.LengthMm() - kLengthMm};
    input.base.orientation = Eigen::AngleAxisd(0.08 * std::sin(2.5 * t), Vector3d(0.6, 0.8, 0.0));
    model_.Solve(state_, input);
    return state_.last;
  }

 private:
  static needle::PathNode Tissue() {
    needle::PathNode tissue;
    tissue.stiffness_n_per_mm2 = 0.1;
    return tissue;
  }
  RodModel model_;
  RodState state_;
  needle::CurvedPath path_;
  std::vector<needle::RodContact> contacts_;
  int step_ = 0;
};

/// A bent needle with its front half in tissue: shape and force on the hand.
RodState BentInTissue(const RodModel& model) {
  needle::PathNode tissue;
  tissue.stiffness_n_per_mm2 = 0.3;
  needle::CurvedPath path;
  path.Begin(tissue);
  path.Advance(Vector3d::UnitZ(), 75.0, tissue);
  std::vector<needle::RodContact> contacts(model.num_elements() + 2);
  const int count = needle::CoupleToPath(model, path, {}, contacts);
  RodInput input;
  input.contacts = {contacts.data(), static_cast<std::size_t>(count)};
  input.base.position_mm = {8.0, -3.0, -74.5};
  input.base.orientation = Eigen::AngleAxisd(0.1, Vector3d::UnitY());
  RodState state = model.NewState();
  model.Solve(state, input);
  return state;
}

void PrintSteps() {
  std::printf(
      "\nA step in tissue (path, coupling, rod), thread CPU time; bent in tissue, against "
      "1201 nodes\n");
  const RodModel fine = Rod(1201);
  const RodState reference = BentInTissue(fine);
  for (const int num_nodes : {15, 25, 50, 100}) {
    Scene scene(num_nodes);
    std::vector<double> times;
    int most = 0;
    int failed = 0;
    for (int i = 0; i < 20000; ++i) {
      const double begin = ThreadMicroseconds();
      const needle::RodResult& result = scene.Step();
      times.push_back(ThreadMicroseconds() - begin);
      most = std::max(most, result.iterations);
      failed += !result.converged();
    }
    std::ranges::sort(times);
    const RodModel model = Rod(num_nodes);
    const RodState bent = BentInTissue(model);
    double off_mm = 0.0;
    for (double arc_mm = 0.0; arc_mm <= kLengthMm; arc_mm += 1.0) {
      off_mm = std::max(
          off_mm, (model.PositionMm(bent, arc_mm) - fine.PositionMm(reference, arc_mm)).norm());
    }
    const double force_n = reference.last.base_force_n.norm();
    const double force_percent =
        100.0 * (bent.last.base_force_n - reference.last.base_force_n).norm() / force_n;
    std::printf(
        "%3d nodes: median %5.1f us, 99 %% %5.1f us; at most %d iterations, %d not converged; "
        "shape within %.4f mm, hand's %.2f N within %.2f %%\n",
        num_nodes, times[10000], times[19800], most, failed, off_mm, force_n, force_percent);
  }
}

void RodStep(benchmark::State& state) {
  Scene scene(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(scene.Step().energy_n_mm);
}
BENCHMARK(RodStep)->Arg(15)->Arg(25)->Arg(50)->Arg(100);

void BulletSubstep(benchmark::State& state) {
  const int num_nodes = static_cast<int>(state.range(0));
  BulletChain chain(ScaledTo(num_nodes, PhysicalSpring(num_nodes)));
  chain.SetTipForce(0.5);
  for (auto _ : state) chain.Substep();
}
BENCHMARK(BulletSubstep)->Arg(15)->Arg(25)->Arg(50);

}  // namespace
}  // namespace acus::bench

int main(int argc, char** argv) {
  const bool only_tables = argc == 2 && std::string_view(argv[1]) == "--tables";
  if (!only_tables) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  }
  acus::bench::PrintDeflections();
  const bool is_ten_times_cheaper = acus::bench::PrintTracking() >= 10.0;
  acus::bench::PrintSteps();
  if (only_tables) return is_ten_times_cheaper ? 0 : 1;
  std::printf("\n");
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
