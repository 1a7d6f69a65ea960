// All that a step of forces can be made of must leave most of the hand's millisecond to others.
#include <algorithm>
#include <cstdio>
#include <gtest/gtest.h>

#include "acus/base/core/cpu_time.h"
#include "acus/base/math/statistics.h"
#include "acus/physics/forces/vidal_probe.h"
#include "benchmarks/force_levels.h"
#include "support/force_scenes.h"

namespace acus::benchmarks {
namespace {

// Every force model, tissue of every level, a needle of 25 nodes, and the probe, one after the
// other in one step: more than any scene calls for. Measured 16 us (2.6 GHz).
TEST(ForceStepSpeed, EveryComponentTogetherTakesLessThanFiftyMicroseconds) {
  const std::vector<ForceLevel> levels = ForceLevels({}, {});
  std::vector<std::function<forces::NeedleForce(const tissue::ToolSample&)>> needles;
  for (const ForceLevel& level : levels) needles.push_back(level.begin());
  const testing_support::LayeredBodyField body(
      {{0.0, "skin", 20}, {2.0, "fat", -100}, {20.0, "bone", 900}});
  const forces::VidalProbe probe(testing_support::ShippedTable("vidal.json"), body);
  testing_support::DrivenProbe driven{probe};

  const std::vector<tissue::ToolSample> samples = SamplesEvery(1.0);
  std::vector<double> all_us;
  std::vector<std::vector<double>> part_us(needles.size() + 1);
  double felt_n = 0.0;
  for (const tissue::ToolSample& sample : samples) {
    const double begin_s = ThreadCpuSeconds();
    double before_s = begin_s;
    for (std::size_t i = 0; i < needles.size(); ++i) {
      felt_n += needles[i](sample).force_in_ct_n.norm();
      const double now_s = ThreadCpuSeconds();
      part_us[i].push_back(1e6 * (now_s - before_s));
      before_s = now_s;
    }
    // Pressed 8 mm into the skin, sliding.
    felt_n +=
        driven.Step(sample.time_s, {sample.time_s, 0.0, std::min(8.0, 20.0 * sample.time_s - 4.0)})
            .force_in_ct_n.norm();
    const double end_s = ThreadCpuSeconds();
    part_us.back().push_back(1e6 * (end_s - before_s));
    all_us.push_back(1e6 * (end_s - begin_s));
  }
  EXPECT_GT(felt_n, 1000.0);
  for (std::size_t i = 0; i < part_us.size(); ++i) {
    std::printf("  %-16s %6.2f us\n", i < levels.size() ? levels[i].name.c_str() : "probe",
                math::Median(part_us[i]));
  }
  std::printf("  %-16s %6.2f us\n", "all", math::Median(all_us));
  EXPECT_LT(math::Median(all_us), 50.0);
}

}  // namespace
}  // namespace acus::benchmarks
