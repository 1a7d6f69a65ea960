// What the deformed image costs per frame with 3D finite elements. Run: build/tests/bench_fem_field
#include <benchmark/benchmark.h>
#include <cmath>

#include "acus/physics/tissue/fem_field.h"
#include "support/box_mesh.h"

namespace acus::tissue {
namespace {

/// 59,319 nodes in a box of 152 mm, 1000 of them reachable, some 6,700 (20,000 rows) stored. The
/// numbers are made up: cost does not depend on them.
struct Scene {
  mesh::TetraMesh mesh = testing_support::BoxMesh({38, 38, 38}, {0, 0, 0}, {152, 152, 152}, 0.15);
  mechanics::CondensedTissue tissue;

  Scene() {
    const auto within = [&](double radius_mm) {
      std::vector<int> nodes;
      for (int i = 0; i < mesh.nodes_mm.cols(); ++i) {
        const Eigen::Vector3d x = mesh.nodes_mm.col(i);
        if (x.z() > 40.0 && std::hypot(x.x() - 76.0, x.y() - 76.0) < radius_mm) nodes.push_back(i);
      }
      return nodes;
    };
    const std::vector<int> reachable = within(13.5);
    const std::vector<int> visible = within(35.0);
    Eigen::MatrixXf block(3 * visible.size(), 3 * reachable.size());
    for (Eigen::Index k = 0; k < block.size(); ++k)
      block.data()[k] = 1e-3f * static_cast<float>(k % 1013);
    tissue.image = mechanics::ImageBlock::FromMatrix(visible, block);
    tissue.compliance = mechanics::Compliance::FromMatrix(
        reachable, Eigen::MatrixXd::Zero(3 * reachable.size(), 3 * reachable.size()),
        mechanics::Storage::kFloat);
  }
};

const FemImage& Image() {
  static const Scene scene;
  static const FemImage image(scene.mesh, scene.tissue);
  return image;
}

/// A needle that bends a little, so that no two points share an element for long.
TissueLoad Load(int num_points, double shift_mm) {
  TissueLoad load;
  load.num_points = num_points;
  for (int p = 0; p < num_points; ++p) {
    load.point[p] = {{76.0 + 0.02 * p + shift_mm, 76.0 - shift_mm, 150.0 - 100.0 * p / num_points},
                     {0.01, 0.02, -0.05}};
  }
  return load;
}

void Update(benchmark::State& state) {
  FemField field(Image());
  int n = 0;
  for (auto _ : state) {
    field.Update(Load(static_cast<int>(state.range(0)), std::sin(0.1 * ++n)));
    benchmark::DoNotOptimize(field);
  }
  state.counters["dropped"] = field.num_dropped_loads();
}
BENCHMARK(Update)->Arg(10)->Arg(20)->Arg(60)->Arg(70)->Unit(benchmark::kMillisecond);

/// A grid of 72 x 70 places over the image plane.
void Look(benchmark::State& state) {
  FemField field(Image());
  field.Update(Load(60, 0.0));
  for (auto _ : state) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int j = 0; j < 70; ++j) {
      for (int i = 0; i < 72; ++i) {
        sum +=
            field.DisplacementMm({76.0 + 0.9 * (i - 36), 76.0 + 0.1 * (i - 36), 150.0 - 1.4 * j});
      }
    }
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * 72 * 70);
}
BENCHMARK(Look)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace acus::tissue

BENCHMARK_MAIN();
