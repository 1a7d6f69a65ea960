// What an image costs, stage by stage. Run: build/tests/bench_ultrasound
#include <benchmark/benchmark.h>
#include <cmath>
#include <filesystem>

#include "acus/base/core/random.h"
#include "acus/data/image/film.h"
#include "acus/imaging/fluoroscopy/fluoroscope.h"
#include "acus/imaging/slicing/ct_slice.h"
#include "acus/imaging/ultrasound/columns/bmode.h"
#include "acus/imaging/ultrasound/display/annotate.h"
#include "support/synthetic_ct.h"

namespace acus::ultrasound {
namespace {

/// As large as a real abdomen: 512 x 512 x 300 voxels.
const volume::CtVolume& Ct() {
  static const volume::CtVolume ct = [] {
    RandomStream random(1, "noise");
    return testing_support::SyntheticCt({512, 512, 300}, 0.7, [&](double x, double y, double) {
      const double noise = 40.0 * (random.Uniform() - 0.5);
      if (y < 100.0) return -1000.0;
      return std::hypot(x - 180.0, y - 130.0) < 6.0 ? 700.0 : 50.0 + noise;
    });
  }();
  return ct;
}

/// 512 lines of 512 samples: no black side saves anything.
acoustics::Probe FullProbe(acoustics::ProbeKind kind) {
  const bool linear = kind == acoustics::ProbeKind::kLinear;
  return {.name = "bench",
          .kind = kind,
          .frequency_mhz = 10,
          .scan_lines = 384,
          .width_mm = 60.2,
          .radius_mm = 50,
          .field_of_view_rad = 0.95,
          .depth_mm = linear ? 60.0 : 150.0,
          .image_width_px = 512,
          .image_height_px = 512,
          .slice_thickness_mm = 3,
          .pulse_length_mm = linear ? 0.7 : 1.6,
          .beam_width_mm = linear ? 1.2 : 2.4,
          .dynamic_range_db = 60,
          .gain_db = 6};
}

/// A probe that moves and tilts: each image reads other voxels.
Eigen::Isometry3d Pose(int n) {
  return Eigen::Translation3d(180 + 5 * std::sin(0.02 * n), 99.9, 100 + 20 * std::sin(0.01 * n)) *
         Eigen::AngleAxisd(0.3 + 0.1 * std::sin(0.03 * n), Eigen::Vector3d::UnitY());
}

image::NeedleInImage Needle(int n) {
  const Eigen::Isometry3d ct_from_probe = Pose(n);
  image::NeedleInImage needle;
  needle.tip_in_ct_mm = ct_from_probe * Eigen::Vector3d(-10, 20, 0.2);
  needle.axis_in_ct = ct_from_probe.linear() * Eigen::Vector3d(0.8, 0.6, 0.0);
  needle.length_mm = 90;
  needle.radius_mm = 0.45;
  return needle;
}

void RenderBMode(benchmark::State& state, acoustics::ProbeKind kind, bool all_stages) {
  BModeOptions options = DefaultBModeOptions();
  options.texture = options.attenuation = all_stages;
  options.angle_exponent = all_stages ? 1 : 0;
  BModeRenderer renderer(Ct(), FullProbe(kind), options);
  image::GrayImage image;
  int n = 0;
  for (auto _ : state) {
    ++n;
    renderer.Render(Pose(n), Needle(n), image, static_cast<int>(state.range(0)));
    benchmark::DoNotOptimize(image.pixels.data());
  }
}
BENCHMARK_CAPTURE(RenderBMode, linear_2010, acoustics::ProbeKind::kLinear, false)
    ->Arg(1)
    ->Arg(2)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(RenderBMode, linear_all_stages, acoustics::ProbeKind::kLinear, true)->Arg(1);
BENCHMARK_CAPTURE(RenderBMode, curvilinear_2010, acoustics::ProbeKind::kCurvilinear, false)->Arg(1);
BENCHMARK_CAPTURE(RenderBMode, curvilinear_all_stages, acoustics::ProbeKind::kCurvilinear, true)
    ->Arg(1);

void SampleSlice(benchmark::State& state) {
  const slicing::CtSampler sampler(Ct());
  const acoustics::ScanGrid grid =
      acoustics::ScanGridOf(acoustics::ImageOf(FullProbe(acoustics::ProbeKind::kLinear)));
  slicing::BeamLines lines;
  slicing::BeamImage hu;
  hu.Resize(grid.lines(), grid.samples);
  int n = 0;
  for (auto _ : state) {
    sampler.PlaceLines(grid, Pose(n++), lines);
    sampler.Sample(lines, acus::slicing::BeamBend(), hu, 1);
    benchmark::DoNotOptimize(hu.row(0));
  }
}
BENCHMARK(SampleSlice);

void RenderCtSlice(benchmark::State& state) {
  slicing::CtSliceRenderer renderer(
      Ct(), acoustics::ImageOf(FullProbe(acoustics::ProbeKind::kLinear)), 3.0);
  image::GrayImage image;
  int n = 0;
  for (auto _ : state) {
    ++n;
    renderer.Render(Pose(n), Needle(n), image);
    benchmark::DoNotOptimize(image.pixels.data());
  }
}
BENCHMARK(RenderCtSlice);

/// A radiograph of 512 x 512 pixels of the whole volume, by the length of the voxels that are
/// summed.
void RenderFluoroscopy(benchmark::State& state) {
  const fluoroscopy::CArm c_arm{.name = "bench", .detail = static_cast<int>(state.range(0))};
  const fluoroscopy::CArmPose pose{.isocentre_in_ct_mm = {180.0, 180.0, 105.0}, .lao_rad = 0.35};
  const auto threads = static_cast<int>(state.range(1));
  fluoroscopy::Fluoroscope fluoroscope(Ct(), c_arm, pose, threads);
  image::GrayImage image;
  int n = 0;
  for (auto _ : state) {
    fluoroscope.Render(Needle(++n), image, threads);
    benchmark::DoNotOptimize(image.pixels.data());
  }
}
BENCHMARK(RenderFluoroscopy)
    ->ArgsProduct({{1, 2, 4}, {1, 2}})
    ->ArgNames({"detail", "threads"})
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

/// One frame of a film of B-mode and CT slice, 1024 x 512, with all that is drawn on it.
void FilmFrame(benchmark::State& state) {
  constexpr int kFrames = 16;
  const acoustics::Probe probe = FullProbe(acoustics::ProbeKind::kLinear);
  BModeRenderer bmode(Ct(), probe, DefaultBModeOptions());
  slicing::CtSliceRenderer slice(Ct(), bmode.image(), 3.0);
  const Screen screen(probe, Screen::Shows::kBoth);
  image::GrayImage left[kFrames];
  image::GrayImage right[kFrames];
  for (int n = 0; n < kFrames; ++n) {
    bmode.Render(Pose(n), Needle(n), left[n]);
    slice.Render(Pose(n), Needle(n), right[n]);
  }
  image::FilmWriter film(std::filesystem::temp_directory_path() / "acus_bench.mp4",
                         screen.width_px(), screen.height_px(),
                         {.quality = static_cast<int>(state.range(0))});
  image::GrayImage frame;
  int n = 0;
  for (auto _ : state) {
    // There and back, so that no frame jumps.
    const int at = std::abs((n++ % (2 * kFrames - 2)) - (kFrames - 1));
    screen.Compose(left[at], &right[at], "t = 12.34 s   F = 1.23 N", frame);
    film.Add(frame);
  }
}
BENCHMARK(FilmFrame)->Arg(23)->Arg(27);

}  // namespace
}  // namespace acus::ultrasound

BENCHMARK_MAIN();
