// What a step of 3D contact costs: thread CPU time of each, on an adversarial hand, checked while
// it is measured. Run: build/tests/bench_contact (some minutes: it condenses meshes of up to
// 118,000 nodes). Table and bounds: docs/models/tissue_contact.md.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <map>
#include <memory>

#include "acus/base/math/statistics.h"
#include "support/contact_handling.h"

namespace acus::testing_support {
namespace {

const HandlingScene& SceneOf(int cells) {
  static std::map<int, std::unique_ptr<HandlingScene>> scenes;
  auto& scene = scenes[cells];
  if (scene == nullptr) {
    scenes.clear();  // One at a time: the largest takes 3 GB to make.
    scenes[cells] = std::make_unique<HandlingScene>(cells, 13.0, 72.0);
    return *scenes[cells];
  }
  return *scene;
}

void ContactStep(benchmark::State& state) {
  const HandlingScene& scene = SceneOf(static_cast<int>(state.range(0)));
  const tissue::FemNeedleModel model = scene.Model();
  AdversarialHand hand(model, static_cast<int>(state.range(1)));
  StepCosts costs;
  costs.all_us.reserve(static_cast<std::size_t>(state.max_iterations));
  costs.engaged_us.reserve(static_cast<std::size_t>(state.max_iterations));
  for (auto _ : state) {
    hand.Step(costs);
    state.SetIterationTime(1e-6 * costs.all_us.back());
  }
  const tissue::FemNeedleState& end = hand.state();
  if (!costs.finite || costs.largest_force_n > 30.0 + 1e-9 || costs.worst_error_n > 1e-9 ||
      costs.least_work_n_mm < -1.0) {
    state.SkipWithError("forces are wrong: bounds of force, energy or a fresh solve are broken");
  }
  state.counters["nodes"] = static_cast<double>(scene.mesh.nodes_mm.cols());
  state.counters["reachable"] = scene.compliance.num_nodes();
  state.counters["points"] = costs.mean_points;
  if (!costs.engaged_us.empty()) {  // The first trial runs may be too short to engage.
    state.counters["median_us"] = math::Median(costs.engaged_us);
    state.counters["p999_us"] = math::Quantile(costs.engaged_us, 0.999);
  }
  state.counters["all_p999_us"] = math::Quantile(costs.all_us, 0.999);
  state.counters["max_us"] = std::ranges::max(costs.all_us);
  state.counters["error_n"] = costs.worst_error_n;
  state.counters["largest_n"] = costs.largest_force_n;
  state.counters["work_n_mm"] = costs.work_n_mm;
  state.counters["least_work"] = costs.least_work_n_mm;
  state.counters["swaps"] = static_cast<double>(end.contact.counts().num_swaps);
  state.counters["rounds"] = static_cast<double>(end.contact.counts().num_rounds) /
                             static_cast<double>(end.contact.counts().num_solves);
  state.counters["fallbacks"] = static_cast<double>(end.contact.counts().num_fallbacks);
  state.counters["refactors"] = static_cast<double>(end.contact.num_refactors());
}
BENCHMARK(ContactStep)
    ->ArgNames({"cells", "points"})
    ->ArgsProduct({{21, 30, 38, 48}, {20, 60}})
    ->Iterations(50'000)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace acus::testing_support

BENCHMARK_MAIN();
