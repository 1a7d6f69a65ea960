// Images of a scene of surfaces by rays against its triangles beside those by voxels, in turns.
// bench_surfaces measures the scene of 7,864,320 triangles.
#include <cstdio>
#include <gtest/gtest.h>

#include "acus/imaging/ultrasound/columns/alamilla.h"
#include "benchmarks/bumpy_balls.h"
#include "support/paired_times.h"

namespace acus::benchmarks {
namespace {

using testing_support::LeastTime;

// Measured: 1.02 at rest and 1.08 deformed; 491,520 triangles.
TEST(TrianglesSpeed, AnImageTakesLittleMoreThanByVoxelsAndIsRight) {
  auto surfaces = BumpyBalls::Surfaces(6);
  double fill_s = 0.0;
  const volume::LabelMap voxels = BumpyBalls::Voxels(surfaces, 0.5, fill_s);
  const tracing::SurfaceTracer tracer(std::move(surfaces), 1);
  const auto options = ultrasound::ReadAlamillaOptions(std::filesystem::path(ACUS_SOURCE_DIR) /
                                                       "configs/acoustics/alamilla_2021.json");
  ultrasound::AlamillaRenderer by_voxels(voxels, BumpyBalls::Probe(), options);
  ultrasound::AlamillaRenderer by_triangles(voxels, BumpyBalls::Probe(), options, &tracer);
  const TakenAlong moved;
  image::GrayImage image;
  for (const slicing::RestMap* rest : {static_cast<const slicing::RestMap*>(nullptr),
                                       static_cast<const slicing::RestMap*>(&moved)}) {
    // Fast, but the same?
    const LabelErrors errors = ErrorsOfTriangles(tracer, rest);
    EXPECT_LT(errors.wrong_percent, 0.1);
    EXPECT_LT(errors.rms_mm, 0.02);
    LeastTime voxel_time, triangle_time;
    const auto share = [&] { return triangle_time.cpu_ms / voxel_time.cpu_ms; };
    const double limit = rest == nullptr ? 1.4 : 1.5;
    testing_support::MeasureUntil(
        20, 400,
        [&] {
          voxel_time.Add(
              [&] { by_voxels.Render(BumpyBalls::CtFromProbe(), std::nullopt, image, 1, rest); });
          triangle_time.Add([&] {
            by_triangles.Render(BumpyBalls::CtFromProbe(), std::nullopt, image, 1, rest);
          });
        },
        [&] { return share() < limit; });
    EXPECT_LT(share(), limit);
    std::printf("%.2f ms by triangles, %.2f of by voxels\n", triangle_time.cpu_ms, share());
  }
}

}  // namespace
}  // namespace acus::benchmarks
