// What an image of a breathing patient costs: volume, fields of several sizes, vertices, and the
// way not taken: the whole volume resampled for each image.
#include <benchmark/benchmark.h>
#include <cmath>
#include <memory>

#include "acus/base/core/parallel.h"
#include "acus/imaging/graphics/shader_rays.h"
#include "acus/imaging/volume_rendering/moving_surface.h"
#include "support/trunk_ct.h"
#include "support/view_scenes.h"
#include "support/vtk_volume.h"
#include "support/wound_sheet.h"

namespace {

using namespace acus;  // NOLINT: a program of one file.

/// Components that a model mixes.
breathing::MotionField Field(int nodes_each_way, int num_components = 2) {
  return testing_support::FieldOf(testing_support::DiaphragmMm, nodes_each_way, num_components,
                                  400.0);
}

breathing::MotionMap MapOf(const breathing::MotionField& field, double breath = 1.0) {
  breathing::MotionWeights weights;
  weights.Add(0, 0.6 * breath);
  weights.Add(1, 0.4 * breath);
  return {field, weights};
}

const char* const kLayers[] = {"skin", "bone", "soft_tissue"};

/// Arguments: layer, width, height, nodes of the field each way (0: no breathing), iterations,
/// tolerance of the lattice in um (0: every sample is inverted).
void BM_Volume(benchmark::State& state) {
  static const auto ct = testing_support::TrunkCt(256);
  const auto nodes = static_cast<int>(state.range(3));
  std::optional<breathing::MotionField> field;
  if (nodes > 0) field.emplace(Field(nodes));
  volume_rendering::PatientInView patient;
  patient.ct = ct;
  patient.layers = {{kLayers[state.range(0)], 1.0}};
  patient.field = field ? &*field : nullptr;
  volume_rendering::ViewSettings settings;
  settings.rays.warp.max_iterations = static_cast<int>(state.range(4));
  settings.rays.warp.lattice_mm = 1e-3 * static_cast<double>(state.range(5));
  volume_rendering::PatientView view(patient, settings);
  const volume_rendering::ImageSize size{static_cast<int>(state.range(1)),
                                         static_cast<int>(state.range(2))};
  const auto camera = LookAt(ViewFrom("oblique", view.box_in_ct_mm(), size), size);
  std::optional<breathing::MotionMap> motion;
  if (field) motion.emplace(MapOf(*field));
  volume_rendering::ViewImage image;
  for (auto _ : state) {
    view.Render(camera, {.motion = motion ? &*motion : nullptr}, image, 1);
  }
  state.SetLabel(kLayers[state.range(0)]);
}
void VolumeArguments(benchmark::internal::Benchmark* b) {
  for (const int layer : {0, 1, 2}) {
    for (const int nodes : {0, 64, 128, 256}) b->Args({layer, 512, 512, nodes, 5, 150});
    b->Args({layer, 512, 512, 128, 5, 0});
  }
  b->Args({0, 512, 512, 64, 1, 0})->Args({0, 512, 512, 64, 50, 0});
  b->Args({0, 1224, 1014, 0, 5, 150})->Args({0, 1224, 1014, 128, 5, 150});
  b->Args({1, 1224, 1014, 0, 5, 150})->Args({1, 1224, 1014, 128, 5, 150});
}
BENCHMARK(BM_Volume)->Apply(VolumeArguments)->Unit(benchmark::kMillisecond)->MinTime(0.4);

/// Table 2 of Fortmeier-2016: 1224 x 1014, CT of 256^3, a field of three components. CPU time of
/// all threads and wall time. Arguments: layer, or 2: a maximum intensity projection; nodes of the
/// field each way, components at a moment (0: at rest; 2: between two key frames; 3: surrogate),
/// threads (0: shaders, on the driver that there is).
void BM_Table2(benchmark::State& state) {
  static const auto ct = testing_support::TrunkCt(256);
  static int nodes = 0;
  static std::optional<breathing::MotionField> field;
  if (nodes != state.range(1)) field.emplace(Field(nodes = static_cast<int>(state.range(1)), 3));
  volume_rendering::PatientInView patient;
  patient.ct = ct;
  const bool is_maximum = state.range(0) == 2;
  volume_rendering::ViewSettings settings;
  if (is_maximum) {
    settings.rays.projection = volume_rendering::Projection::kMaximum;
  } else {
    patient.layers = {{kLayers[state.range(0)], 1.0}};
  }
  patient.field = &*field;
  volume_rendering::PatientView view(patient, settings);
  const volume_rendering::ImageSize size{1224, 1014};
  const auto camera = LookAt(ViewFrom("oblique", view.box_in_ct_mm(), size), size);
  const auto threads = static_cast<int>(state.range(3));
  std::string on;
  if (threads == 0) {
    auto card = graphics::MakeShaderRays(graphics::DriverKind::kAny);
    on = " on " + card->name();
    view.UseDevice(std::move(card));
  }
  breathing::MotionWeights weights;
  const double shares[] = {0.5, 0.7, 0.6};
  for (int n = 0; n < state.range(2); ++n) weights.Add(n, shares[n]);
  const breathing::MotionMap motion(*field, weights);
  volume_rendering::ViewImage image;
  for (auto _ : state) {
    view.Render(camera, {.motion = &motion}, image, std::max(1, threads));
  }
  state.counters["field_MB"] = 1e-6 * static_cast<double>(field->bytes());
  state.SetLabel((is_maximum ? "MIP" : kLayers[state.range(0)]) + on);
}
BENCHMARK(BM_Table2)
    ->ArgsProduct({{0, 1, 2}, {64, 128, 256}, {0, 2, 3}, {1, 2, 0}})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->MinTime(0.2);

/// The same image at rest by VTK's ray caster for CPUs, one thread, under a display (Xvfb).
/// Argument: layer. CPU time of the process: the thread of its mapper is not ours.
void BM_VtkFixedPoint(benchmark::State& state) {
  static const auto ct = testing_support::TrunkCt(256);
  const char* layer = kLayers[state.range(0)];
  const volume_rendering::ImageSize size{512, 512};
  volume_rendering::PatientView ours({.ct = ct, .layers = {{layer, 1.0}}, .surfaces = {}}, {});
  const auto camera = LookAt(ViewFrom("oblique", ours.box_in_ct_mm(), size), size);
  try {
    const auto file = volume_rendering::FindTransferFunction(layer, {});
    testing_support::VtkVolume theirs(*ct, volume_rendering::ReadTransferFunction(file).nodes,
                                      camera, 1.0, 1);
    theirs.Render();  // Gradients are made in the first.
    for (auto _ : state) theirs.Render();
    state.counters["covered"] = theirs.CoveredShare();
    state.SetLabel(layer);
  } catch (const std::exception& error) {
    state.SkipWithError(error.what());
  }
}
BENCHMARK(BM_VtkFixedPoint)
    ->DenseRange(0, 2)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->MinTime(0.4);

/// The way not taken: the inverse at every knot of a lattice (argument: its spacing, mm), five
/// iterations from the knot before; what any volume mapper would then have to resample from.
void BM_InverseLattice(benchmark::State& state) {
  const auto field = Field(128);
  const auto motion = MapOf(field);
  const double spacing_mm = static_cast<double>(state.range(0));
  const int count = static_cast<int>(360.0 / spacing_mm);
  for (auto _ : state) {
    double sum = 0.0;
    for (int k = 0; k < count; ++k) {
      for (int j = 0; j < count; ++j) {
        Eigen::Vector3d displacement = Eigen::Vector3d::Zero();
        for (int i = 0; i < count; ++i) {
          const Eigen::Vector3d world =
              spacing_mm * Eigen::Vector3d(i, j, k) - Eigen::Vector3d::Constant(180.0);
          const auto found = motion.RestOf(world, world - displacement,
                                           {.max_iterations = 5, .tolerance_mm = 0.05});
          displacement = world - found.rest_mm;
          sum += displacement[2];
        }
      }
    }
    benchmark::DoNotOptimize(sum);
  }
}
BENCHMARK(BM_InverseLattice)->Arg(8)->Arg(4)->Arg(2)->Unit(benchmark::kMillisecond);

/// Arguments: vertices (of the paper's bone, skin and vessels), nodes of the field each way,
/// threads. With normals; the breath goes on from image to image.
void BM_Vertices(benchmark::State& state) {
  const auto field = Field(static_cast<int>(state.range(1)));
  volume_rendering::MovingSurface surface(testing_support::WoundSheet(state.range(0)));
  double breath = 0.5;
  for (auto _ : state) {
    breath += 0.001;
    const breathing::MotionMap motion = MapOf(field, breath);
    surface.Update(&motion, static_cast<int>(state.range(2)));
  }
}
BENCHMARK(BM_Vertices)
    ->Args({430578, 128, 1})
    ->Args({145648, 128, 1})
    ->Args({12026, 128, 1})
    ->Args({430578, 64, 1})
    ->Args({430578, 256, 1})
    ->Args({430578, 128, 2})
    ->UseRealTime()
    ->Unit(benchmark::kMicrosecond);

/// A surface of 430,000 vertices and its normals, drawn at 512 x 512.
void BM_Surface(benchmark::State& state) {
  const auto field = Field(128);
  const auto motion = MapOf(field);
  volume_rendering::PatientInView patient;
  patient.surfaces = {{"ball", testing_support::BallSurface(Eigen::Vector3d::Zero(), 120.0, 463)}};
  patient.field = &field;
  volume_rendering::PatientView view(patient, {});
  const volume_rendering::ImageSize size{512, 512};
  const auto camera = LookAt(ViewFrom("oblique", view.box_in_ct_mm(), size), size);
  volume_rendering::ViewImage image;
  for (auto _ : state) {
    view.Render(camera, {.motion = state.range(0) != 0 ? &motion : nullptr}, image, 1);
  }
}
BENCHMARK(BM_Surface)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
