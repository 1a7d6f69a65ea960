// B-mode against vtkImageReslice: the same CT, the same plane, the same two threads, in one run.
// Run: build/tests/bench_reslice. The counters wall_share and cpu_share are our time over VTK's, of
// runs that take turns.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <cmath>
#include <filesystem>
#include <optional>

#include "acus/imaging/slicing/ct_slice.h"
#include "acus/imaging/ultrasound/beams/beam_renderer.h"
#include "acus/imaging/ultrasound/columns/bmode.h"
#include "support/paired_times.h"
#include "support/reslice_scene.h"
#include "support/vtk_reslice.h"

namespace acus::ultrasound {
namespace {

using testing_support::FullLinearProbe;
using testing_support::LeastTime;
using testing_support::NeedleInPlane;
using testing_support::SwayingProbe;
using testing_support::VtkReslice;

constexpr int kThreads = 2;

const volume::CtVolume& Ct() {
  static const volume::CtVolume ct = testing_support::AbdomenCt();
  return ct;
}

void Reslice(benchmark::State& state, VtkReslice::Threads threads) {
  VtkReslice reslice(Ct(), acoustics::ImageOf(FullLinearProbe()), kThreads, threads);
  int n = 0;
  for (auto _ : state) benchmark::DoNotOptimize(reslice.Render(SwayingProbe(n++)));
}
BENCHMARK_CAPTURE(Reslice, multithreader, VtkReslice::Threads::kMultiThreader)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK_CAPTURE(Reslice, smp, VtkReslice::Threads::kSmp)->MeasureProcessCPUTime()->UseRealTime();

/// Renders in turns with VTK, and says what share of its time ours takes.
/// @param render  Makes the image at a pose.
template <typename Render>
void ReportShare(benchmark::State& state, VtkReslice::Threads threads, const Render& render) {
  const image::ImageGeometry image = acoustics::ImageOf(FullLinearProbe());
  VtkReslice reslice(Ct(), image, kThreads, threads);
  slicing::CtSliceRenderer slice(Ct(), image, 3.0);
  LeastTime theirs;
  LeastTime ours;
  int n = 0;
  for (auto _ : state) {
    const Eigen::Isometry3d pose = SwayingProbe(n++);
    theirs.Add([&] { benchmark::DoNotOptimize(reslice.Render(pose)); });
    ours.Add([&] { benchmark::DoNotOptimize(render(pose).pixels.data()); });
  }
  const Eigen::Isometry3d pose = SwayingProbe(7);
  const double difference_hu = testing_support::LargestDifferenceHu(reslice, slice, pose);
  if (difference_hu > 1.0) state.SkipWithError("the slices differ by more than one HU");
  if (testing_support::MeanGrey(render(pose)) < 5.0) state.SkipWithError("the image is black");
  state.counters["vtk_wall_ms"] = theirs.wall_ms;
  state.counters["wall_ms"] = ours.wall_ms;
  state.counters["wall_share"] = ours.wall_ms / theirs.wall_ms;
  state.counters["cpu_share"] = ours.cpu_ms / theirs.cpu_ms;
  state.counters["slice_differs_hu"] = difference_hu;
}

void CtSliceShare(benchmark::State& state, VtkReslice::Threads threads) {
  slicing::CtSliceRenderer renderer(Ct(), acoustics::ImageOf(FullLinearProbe()), 3.0);
  image::GrayImage image;
  ReportShare(state, threads, [&](const Eigen::Isometry3d& pose) -> const image::GrayImage& {
    renderer.Render(pose, NeedleInPlane(pose), image, kThreads);
    return image;
  });
}
BENCHMARK_CAPTURE(CtSliceShare, smp, VtkReslice::Threads::kSmp);

void Columns2010Share(benchmark::State& state, VtkReslice::Threads threads) {
  BModeRenderer renderer(Ct(), FullLinearProbe(), DefaultBModeOptions());
  image::GrayImage image;
  ReportShare(state, threads, [&](const Eigen::Isometry3d& pose) -> const image::GrayImage& {
    renderer.Render(pose, NeedleInPlane(pose), image, kThreads);
    return image;
  });
}
BENCHMARK_CAPTURE(Columns2010Share, multithreader, VtkReslice::Threads::kMultiThreader);
BENCHMARK_CAPTURE(Columns2010Share, smp, VtkReslice::Threads::kSmp);

/// Every standard effect on: deformation and breathing, needle, reflection by angle, attenuation,
/// shadow, comet tails, speckle, point spread, compression.
struct AllEffects {
  AllEffects(const volume::CtVolume& ct, const acoustics::Probe& probe, int planes) {
    BeamOptions options;
    options.elevation_planes = planes;
    table = acoustics::ReadTissueAcoustics(std::filesystem::path(ACUS_SOURCE_DIR) /
                                           "configs/acoustics/tissues.json");
    renderer.emplace(BeamTissue{.ct = &ct, .acoustics = &table}, probe, options);
  }
  const image::GrayImage& Render(const Eigen::Isometry3d& pose) {
    const image::NeedleInImage needle = NeedleInPlane(pose);
    const testing_support::BreathingAndNeedle rest(n++, needle.tip_in_ct_mm);
    renderer->Render(pose, needle, image, kThreads, &rest);
    return image;
  }
  acoustics::TissueAcousticsTable table;
  std::optional<BeamRenderer> renderer;
  image::GrayImage image;
  int n = 0;
};

void BeamsShare(benchmark::State& state, VtkReslice::Threads threads) {
  AllEffects beams(Ct(), testing_support::FullBeamProbe(256, 512), 1);
  ReportShare(state, threads, [&](const Eigen::Isometry3d& pose) -> const image::GrayImage& {
    return beams.Render(pose);
  });
}
BENCHMARK_CAPTURE(BeamsShare, multithreader, VtkReslice::Threads::kMultiThreader);
BENCHMARK_CAPTURE(BeamsShare, smp, VtkReslice::Threads::kSmp);

/// Images per second on two threads: lines, samples, planes, width and height of the image.
void BeamsRate(benchmark::State& state) {
  acoustics::Probe probe = testing_support::FullBeamProbe(static_cast<int>(state.range(0)),
                                                          static_cast<int>(state.range(1)));
  probe.image_width_px = static_cast<int>(state.range(3));
  probe.image_height_px = static_cast<int>(state.range(4));
  AllEffects beams(Ct(), probe, static_cast<int>(state.range(2)));
  int n = 0;
  LeastTime least;
  for (auto _ : state) {
    const Eigen::Isometry3d pose = SwayingProbe(n++);
    least.Add([&] { benchmark::DoNotOptimize(beams.Render(pose).pixels.data()); });
  }
  if (testing_support::MeanGrey(beams.image) < 5.0) state.SkipWithError("the image is black");
  state.counters["images_per_s"] = 1e3 / least.wall_ms;
  state.counters["cpu_ms"] = least.cpu_ms;
}
BENCHMARK(BeamsRate)->Args({256, 4096, 1, 500, 500})->Args({256, 2048, 5, 820, 616});

}  // namespace
}  // namespace acus::ultrasound

BENCHMARK_MAIN();
