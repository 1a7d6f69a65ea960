// Surfaces that breathe: what a moment costs, whatever the size of the field of motion.
#include <algorithm>
#include <cstdio>
#include <gtest/gtest.h>
#include <map>

#include "acus/base/core/cpu_time.h"
#include "acus/imaging/volume_rendering/moving_surface.h"
#include "acus/physics/breathing/moved_points.h"
#include "support/paired_times.h"
#include "support/view_scenes.h"
#include "support/wound_sheet.h"

namespace acus {
namespace {

constexpr int kVertices = 430'578;  // Fortmeier-2016, section 4.4.

breathing::MotionField Field(int nodes_each_way) {
  return testing_support::FieldOf(testing_support::DiaphragmMm, nodes_each_way, 3, 400.0);
}

breathing::MotionWeights WeightsAt(int moment) {
  breathing::MotionWeights weights;
  for (int n = 0; n < 3; ++n) weights.Add(n, 0.3 + 0.001 * moment);
  return weights;
}

/// Least CPU times of one core, ms.
struct Times {
  double moved = 1e9;    ///< A moment of the surface, with normals.
  double sampled = 1e9;  ///< The field at each vertex, without normals.
};

// Measured: 2.4 to 3.6 ms with any field; sampled 6.7, 9.1 and 14 ms.
TEST(SurfaceSpeed, AMomentCostsTheSameForEveryFieldAndHalfOfSamplingALargeOne) {
  volume_rendering::MovingSurface surface(testing_support::WoundSheet(kVertices));
  const Eigen::Matrix3Xf rest_mm = surface.nodes_mm();
  Eigen::Matrix3Xf moved_mm = rest_mm;
  const std::map<int, breathing::MotionField> fields{{64, Field(64)}, {256, Field(256)}};
  std::map<int, Times> times;
  int moment = 0;
  const auto measure = [&] {
    for (const auto& [nodes, field] : fields) {
      Times& best = times[nodes];
      for (int n = 0; n < 4; ++n) {  // The first one looks the field up.
        const breathing::MotionMap motion(field, WeightsAt(++moment));
        const double begin_s = ThreadCpuSeconds();
        surface.Update(&motion, 1);
        if (n > 0) best.moved = std::min(best.moved, 1e3 * (ThreadCpuSeconds() - begin_s));
      }
      const breathing::MotionMap motion(field, WeightsAt(moment));
      const double begin_s = ThreadCpuSeconds();
      breathing::DisplacementsMm(motion, rest_mm, moved_mm);
      best.sampled = std::min(best.sampled, 1e3 * (ThreadCpuSeconds() - begin_s));
      moved_mm += rest_mm;
      ASSERT_LT((moved_mm - surface.nodes_mm()).cwiseAbs().maxCoeff(), 2e-3F);
    }
  };
  const auto same = [&] {
    return std::max(times[64].moved, times[256].moved) <
           1.3 * std::min(times[64].moved, times[256].moved);
  };
  const auto half = [&] { return times[256].moved < 0.5 * times[256].sampled; };
  testing_support::MeasureUntil(10, 100, measure, [&] { return same() && half(); });
  for (const auto& [nodes, best] : times) {
    std::printf("  %d^3 nodes: moved in %.2f ms, sampled in %.2f ms\n", nodes, best.moved,
                best.sampled);
  }
  EXPECT_TRUE(same());
  EXPECT_TRUE(half());
}

// While the breath is held, nothing is computed.
TEST(SurfaceSpeed, ABreathThatIsHeldCostsNothing) {
  const breathing::MotionField field = Field(32);
  volume_rendering::MovingSurface surface(testing_support::WoundSheet(kVertices));
  const breathing::MotionMap motion(field, WeightsAt(0));
  surface.Update(&motion, 1);
  double best_ms = 1e9;
  for (int n = 0; n < 20; ++n) {
    const double begin_s = ThreadCpuSeconds();
    surface.Update(&motion, 1);
    best_ms = std::min(best_ms, 1e3 * (ThreadCpuSeconds() - begin_s));
  }
  EXPECT_LT(best_ms, 0.05);
}

}  // namespace
}  // namespace acus
