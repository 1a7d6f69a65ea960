// The 2D model of 2010: update frequency against nodes, with all of the inverse updated and with
// the needle's rows only, as the paper reports it (361 nodes: 512 Hz; over 1000 at 1 kHz
// restricted). Run: build/tests/bench_plane_model. CPU is time of the thread. Every run checks its
// forces against a new factorisation, and forces and energy against bounds.
#include <Eigen/Cholesky>
#include <algorithm>
#include <benchmark/benchmark.h>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "acus/base/core/cpu_time.h"
#include "acus/base/math/statistics.h"
#include "acus/physics/tissue/displacement_functions.h"
#include "acus/physics/tissue/plane_model_2010.h"
#include "acus/physics/tissue/spring_model.h"
#include "support/layered_tissue.h"

namespace acus::tissue {
namespace {

const testing_support::Layers kBody{{{0, "skin"}, {2, "fat"}, {20, "liver"}}};

/// Grids of 11, 19, 32, 45 and 63 nodes a side, near enough.
PlaneSettings SettingsFor(int nodes) {
  PlaneSettings settings;
  settings.width_mm = 90.0;
  const int columns = nodes < 200    ? 11
                      : nodes < 500  ? 19
                      : nodes < 1500 ? 31
                      : nodes < 3000 ? 45
                                     : 63;
  settings.spacing_mm = 90.0 / (columns - 1);
  const int rows = (nodes + columns / 2) / columns;
  const int above = std::max(1, rows / 12);
  settings.above_mm = above * settings.spacing_mm;
  settings.depth_mm = (rows - 1 - above) * settings.spacing_mm;
  return settings;
}

/// One at a time: the largest has 8000 unknowns.
const PlaneModel2010& Model(int nodes) {
  static int made_for = 0;
  static std::unique_ptr<PlaneModel2010> model;
  if (made_for != nodes) {
    model.reset();
    model = std::make_unique<PlaneModel2010>(
        SettingsFor(nodes), PlanePlacement{}, testing_support::RoundForces(),
        testing_support::Trocar18(), testing_support::RoundElasticity(), kBody.At());
    made_for = nodes;
  }
  return *model;
}

double ErrorOfFreshSolveN(const PlaneContact& contact) {
  std::vector<int> stick;
  for (int i = 0; i < contact.size(); ++i) {
    if (contact.Status(i) == SlotStatus::kStick) stick.push_back(i);
  }
  const int m = static_cast<int>(stick.size());
  Eigen::MatrixXd c(m, m);
  Eigen::VectorXd right(m);
  for (int i = 0; i < m; ++i) {
    right[i] = contact.DisplacementMm(stick[i]);
    for (int j = 0; j < m; ++j) c(i, j) = contact.Compliance(stick[i], stick[j]);
    for (int j = 0; j < contact.size(); ++j) {
      if (contact.Status(j) == SlotStatus::kStick) continue;
      right[i] -= contact.Compliance(stick[i], j) * contact.ForceN(j);
    }
  }
  if (m == 0) return 0.0;
  const Eigen::VectorXd force = c.llt().solve(right);
  double worst = 0.0;
  for (int i = 0; i < m; ++i)
    worst = std::max(worst, std::abs(force[i] - contact.ForceN(stick[i])));
  return worst;
}

/// What the paper counts: one node changes between stick and slip, and the forces at the needle.
void OneSwap(benchmark::State& run, PlaneUpdate update) {
  const PlaneModel2010& model = Model(static_cast<int>(run.range(0)));
  const mechanics::PlaneGrid& grid = model.planes().grid();
  const int capacity = 2 * std::min(96, grid.rows);
  PlaneContact contact(model.planes().compliance(), capacity, update);
  for (int row = 0; row < grid.rows && contact.size() < capacity; ++row) {
    const int dof = model.planes().dof_of_node()[grid.Node(grid.columns / 2, row)];
    if (dof >= 0) contact.Append(dof, 0.0, 1.0);
  }
  for (int i = 0; i < contact.size(); ++i) {
    contact.SetDemand(i, i % 2 == 0 ? 1.0 : 0.1, -0.1, 1e3);
  }
  contact.Solve(1e-10);
  int slot = 0;
  for (auto _ : run) {
    contact.SwapForTest(slot);
    benchmark::DoNotOptimize(contact.ForceN(0));
    slot = (slot + 2) % contact.size();
  }
  double largest_n = 0.0;
  for (int i = 0; i < contact.size(); ++i) {
    largest_n = std::max(largest_n, std::abs(contact.ForceN(i)));
  }
  const double error_n = ErrorOfFreshSolveN(contact);
  if (!(error_n <= 1e-9 && largest_n < 100.0)) run.SkipWithError("the forces are wrong");
  run.counters["nodes"] = grid.num_nodes();
  run.counters["free"] = model.planes().num_free_nodes();
  run.counters["needle"] = contact.size() / 2;
  run.counters["error_N"] = error_n;
  run.counters["Hz"] = benchmark::Counter(1.0, benchmark::Counter::kIsIterationInvariantRate);
}

/// Whole steps of the model, the needle going in and to and fro.
void Step(benchmark::State& run, PlaneUpdate update) {
  const PlaneModel2010& shared = Model(static_cast<int>(run.range(0)));
  PlaneModel2010 model = shared.WithUpdate(update);
  testing_support::ModelInsertion<PlaneModel2010> insertion{model};
  insertion.MoveToDepth(30.0, 200.0);
  std::vector<double> us;
  double worst_n = 0.0;
  double largest_n = 0.0;
  double largest_energy = 0.0;
  int n = 0;
  for (auto _ : run) {
    // 5 mm strokes at 20 mm/s on top of a slow advance: all nodes change at every reversal.
    const double depth_mm = 30.0 + 20.0 * (1.0 - std::cos(2e-4 * n)) + 2.5 * std::sin(8e-3 * n);
    ++n;
    const double begin = ThreadCpuSeconds();
    insertion.StepTo(Eigen::Vector3d(0.1 * std::sin(0.01 * n), 0, depth_mm));
    us.push_back(1e6 * (ThreadCpuSeconds() - begin));
    insertion.log.clear();
    run.PauseTiming();
    double energy = 0.0;
    const PlaneContact& contact = insertion.state.contact;
    for (int i = 0; i < contact.size(); ++i) {
      energy += 0.5 * contact.ForceN(i) * contact.DisplacementMm(i);
    }
    largest_energy = std::max(largest_energy, std::abs(energy));
    largest_n = std::max(largest_n, insertion.last.force_in_ct_n.norm());
    if (n % 97 == 0) worst_n = std::max(worst_n, ErrorOfFreshSolveN(contact));
    run.ResumeTiming();
  }
  if (!(worst_n <= 1e-9 && largest_n < 10.0 && largest_energy < 100.0)) {
    run.SkipWithError("the forces are wrong");
  }
  run.counters["nodes"] = model.planes().grid().num_nodes();
  run.counters["median_us"] = math::Median(us);
  run.counters["p99.9_us"] = math::Quantile(us, 0.999);
  run.counters["swaps_per_step"] =
      static_cast<double>(insertion.state.contact.num_swaps()) / static_cast<double>(n);
  run.counters["error_N"] = worst_n;
}

void SpringStep(benchmark::State& run) {
  const SpringModel model({}, testing_support::RoundForces(), testing_support::Trocar18(),
                          testing_support::RoundElasticity(), kBody.Tissues(), kBody.At());
  testing_support::ModelInsertion<SpringModel> insertion{model};
  insertion.MoveToDepth(30.0, 200.0);
  int n = 0;
  for (auto _ : run) {
    const double depth_mm = 30.0 + 20.0 * (1.0 - std::cos(2e-4 * n)) + 2.5 * std::sin(8e-3 * n);
    ++n;
    insertion.StepTo(Eigen::Vector3d(0.1 * std::sin(0.01 * n), 0, depth_mm));
    insertion.log.clear();
  }
  if (!(insertion.last.force_in_ct_n.norm() < 10.0)) run.SkipWithError("the force is wrong");
}

void Field(benchmark::State& run) {
  const PlaneModel2010& model = Model(static_cast<int>(run.range(0)));
  testing_support::ModelInsertion<PlaneModel2010> insertion{model};
  insertion.MoveToDepth(50.0, 200.0);
  PlaneField2010 field(model);
  TissueLoad load;
  model.LoadOf(insertion.state, load);
  for (auto _ : run) field.Update(load);
  if (!(field.DisplacementMm(Eigen::Vector3d(0, 0, 30)).norm() < 10.0)) run.SkipWithError("wrong");
  run.counters["points"] = load.num_points;
}

/// An image of 512 x 512 points, 0.15 mm apart, in the plane of the needle.
template <class Field>
void Image(benchmark::State& run, Field& field) {
  double sum = 0.0;
  for (auto _ : run) {
    for (int row = 0; row < 512; ++row) {
      for (int column = 0; column < 512; ++column) {
        sum += field.DisplacementMm(Eigen::Vector3d(0.15 * (column - 256), 1.0, 0.15 * row)).z();
      }
    }
  }
  if (!(std::abs(sum) > 1.0)) run.SkipWithError("nothing moves");
  run.counters["ns_per_point"] =
      benchmark::Counter(512.0 * 512.0 * 1e-9, benchmark::Counter::kIsIterationInvariantRate |
                                                   benchmark::Counter::kInvert);
}

void FunctionsImage(benchmark::State& run) {
  const TissueAt tissue_at = kBody.At();
  const DisplacementFunctions functions(
      {}, [&](const Eigen::Vector3d& p) { return tissue_at(p) == 0 ? 0.0 : 0.01; });
  DisplacementFunctionsField field(functions);
  TissueLoad load;
  load.needle.in_contact = load.needle.pierced = true;
  load.needle.tip_in_ct_mm = Eigen::Vector3d(0, 0, 50);
  load.needle.cutting_n = load.needle.friction_n = 1.0;
  field.Update(load);
  Image(run, field);
}

template <class Model, class ModelField>
void ModelImage(benchmark::State& run, const Model& model) {
  testing_support::ModelInsertion<Model> insertion{model};
  insertion.MoveToDepth(50.0, 200.0);
  TissueLoad load;
  model.LoadOf(insertion.state, load);
  ModelField field(model);
  field.Update(load);
  Image(run, field);
}

void SpringsImage(benchmark::State& run) {
  const SpringModel model({}, testing_support::RoundForces(), testing_support::Trocar18(),
                          testing_support::RoundElasticity(), kBody.Tissues(), kBody.At());
  ModelImage<SpringModel, SpringField>(run, model);
}

void PlaneImage(benchmark::State& run) {
  ModelImage<PlaneModel2010, PlaneField2010>(run, Model(1000));
}

void Nodes(benchmark::internal::Benchmark* b) {
  for (const int nodes : {121, 361, 1000, 2000, 4000}) b->Arg(nodes);
}

BENCHMARK_CAPTURE(OneSwap, restricted, PlaneUpdate::kRestricted)->Apply(Nodes);
BENCHMARK_CAPTURE(OneSwap, full, PlaneUpdate::kFull)->Apply(Nodes)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Step, restricted, PlaneUpdate::kRestricted)
    ->Apply(Nodes)
    ->Iterations(20000)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Step, full, PlaneUpdate::kFull)
    ->Arg(121)
    ->Arg(361)
    ->Arg(1000)
    ->Iterations(2000)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(FunctionsImage)->Unit(benchmark::kMillisecond);
BENCHMARK(SpringsImage)->Unit(benchmark::kMillisecond);
BENCHMARK(PlaneImage)->Unit(benchmark::kMillisecond);
BENCHMARK(SpringStep)->Unit(benchmark::kMicrosecond);
BENCHMARK(Field)->Arg(1000)->Arg(4000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace acus::tissue

BENCHMARK_MAIN();
