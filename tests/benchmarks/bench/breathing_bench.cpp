// What breathing costs: displacements for a needle's nodes, the inverse for a tool and for the
// knots of an image, and a whole step by every motion model. Run: build/tests/bench_breathing
#include <benchmark/benchmark.h>
#include <cmath>

#include "acus/physics/breathing/motion_map.h"
#include "acus/physics/breathing/tool_at_rest.h"
#include "acus/scene/simulation/simulation.h"
#include "support/bending_scene.h"
#include "support/breathing_patients.h"

namespace acus::breathing {
namespace {

/// 350 mm of patient, 20 mm of smooth motion, as many components as a model mixes.
MotionField Field(int per_axis, int components) {
  volume::Geometry nodes;
  nodes.size = {per_axis, per_axis, per_axis};
  nodes.spacing_mm = Eigen::Array3d::Constant(350.0 / (per_axis - 1));
  MotionField field(nodes, components);
  std::vector<float> values(3 * nodes.num_voxels());
  for (int c = 0; c < components; ++c) {
    for (std::size_t n = 0; n < values.size(); ++n) {
      const double k = static_cast<double>(n / 3) / static_cast<double>(nodes.num_voxels());
      values[n] = static_cast<float>(10.0 * std::sin(3.0 * k + c));
    }
    field.SetComponent(c, values);
  }
  return field;
}

MotionWeights Weights(int components, double share) {
  MotionWeights weights;
  for (int c = 0; c < components; ++c) weights.Add(c, share / (1.0 + c));
  return weights;
}

/// Two components: key frames. Three: the surrogate model.
void NeedleNodes(benchmark::State& state) {
  const auto components = static_cast<int>(state.range(1));
  const MotionField field = Field(static_cast<int>(state.range(0)), components);
  const MotionMap map(field, Weights(components, 0.7));
  double moved_mm = 0.0;
  for (auto _ : state) {
    moved_mm += 1e-3;
    for (int n = 0; n < 25; ++n) {
      benchmark::DoNotOptimize(
          map.DisplacementMm({100.0 + 3.6 * n + moved_mm, 120.0 + 4.8 * n, 90.0}));
    }
    if (moved_mm > 50.0) moved_mm = 0.0;
  }
}
BENCHMARK(NeedleNodes)->ArgsProduct({{64, 128, 256}, {2, 3}})->ArgNames({"nodes", "fields"});

void ToolInAStep(benchmark::State& state) {
  const MotionField field = Field(128, 2);
  ToolTrack track;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << 170, 150, 160;
  double share = 0.0;
  for (auto _ : state) {
    share += 5e-4;  // A kilohertz of a breath of two seconds.
    const MotionMap map(field, Weights(2, std::sin(share)));
    benchmark::DoNotOptimize(AtRest(map, pose, Eigen::Vector3d::UnitZ(), track));
  }
}
BENCHMARK(ToolInAStep);

/// 150 x 150 mm, knots 5 mm apart, five iterations each from the neighbour.
void ImageKnots(benchmark::State& state) {
  const MotionField field = Field(static_cast<int>(state.range(0)), 2);
  const MotionMap map(field, Weights(2, 0.7));
  for (auto _ : state) {
    for (double y = 0; y < 150; y += 5) {
      Eigen::Vector3d moved_mm = Eigen::Vector3d::Zero();
      for (double x = 0; x < 150; x += 5) {
        const Eigen::Vector3d place_mm(80 + x, 90 + 0.7 * y, 100 + 0.7 * y);
        const auto found =
            map.RestOf(place_mm, place_mm + moved_mm, {.max_iterations = 5, .tolerance_mm = 0.02});
        moved_mm = found.rest_mm - place_mm;
      }
      benchmark::DoNotOptimize(moved_mm);
    }
  }
}
BENCHMARK(ImageKnots)->Arg(64)->Arg(128)->Arg(256);

/// Layered forces and a needle of 25 nodes, 45 mm deep in tissue that moves across it. Arguments:
/// the model (4: no breathing), nodes of its field each way.
void NeedleStep(benchmark::State& state) {
  testing_support::BendingScene bending;
  bending.tissue = nullptr;
  simulation::Scene scene = bending.Make();
  const auto kind = static_cast<std::size_t>(state.range(0));
  if (kind < testing_support::kAllMotionKinds.size()) {
    testing_support::BreathingPatient patient{.kind = testing_support::kAllMotionKinds[kind],
                                              .nodes_per_axis = static_cast<int>(state.range(1))};
    patient.box.size.setConstant(301);
    patient.box.origin_mm = {-150.0, -150.0, -70.0};
    patient.towards = {0.0, 1.0, 0.3};
    scene.breathing.emplace(patient.Make());
    state.SetLabel(std::string(NameOf(patient.kind)));
  }
  const simulation::Simulation simulation(scene);
  simulation::State of_simulation = simulation.NewState();
  int step = 0;
  for (auto _ : state) {
    const double t = 1e-3 * step++;
    const double depth_mm = t < 1.0 ? 45.0 * t - 2.0 : 43.0 + 8.0 * std::sin(2.0 * t - 2.0);
    benchmark::DoNotOptimize(simulation.Step(
        of_simulation,
        testing_support::NeedleAt(t, {std::sin(3.0 * t), std::cos(2.1 * t), depth_mm},
                                  {0.1 * std::sin(2.5 * t), 0.05, 0.0})));
  }
}
BENCHMARK(NeedleStep)
    ->Args({4, 0})
    ->ArgsProduct({{0, 1, 2, 3}, {64, 128, 256}})
    ->ArgNames({"model", "nodes"});

}  // namespace
}  // namespace acus::breathing

BENCHMARK_MAIN();
