#include "benchmarks/insertion.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/math/statistics.h"

namespace acus::benchmarks {
namespace {

using testing::HasSubstr;

/// Pushes back along the axis by a force that the test chooses, from the position of the tip.
struct Pusher {
  std::function<Eigen::Vector3d(const tissue::ToolSample&, const tissue::ToolSample& before)> force;
  struct State {
    tissue::ToolSample before;
  };
  State NewState() const { return {ScriptedInsertion().front()}; }
  forces::NeedleForce Step(State& state, const tissue::ToolSample& sample) const {
    forces::NeedleForce out;
    out.force_in_ct_n = force(sample, state.before);
    state.before = sample;
    return out;
  }
};

/// Constant friction against every movement below the skin.
Eigen::Vector3d Friction(const tissue::ToolSample& now, const tissue::ToolSample& before) {
  const Eigen::Vector3d way = now.tip_in_ct_mm - before.tip_in_ct_mm;
  if (now.tip_in_ct_mm[2] > 0.0 || way.norm() == 0.0) return Eigen::Vector3d::Zero();
  return -0.5 * way.normalized();
}

TEST(ScriptedInsertion, GoesInAsideAndOutAtOneKilohertz) {
  const auto samples = ScriptedInsertion();
  double lowest_mm = 0.0;
  double aside_mm = 0.0;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    EXPECT_NEAR(samples[n].time_s, 1e-3 * static_cast<double>(n), 1e-12);
    EXPECT_NEAR(samples[n].axis_in_ct.norm(), 1.0, 1e-12);
    lowest_mm = std::min(lowest_mm, samples[n].tip_in_ct_mm[2]);
    aside_mm = std::max(aside_mm, samples[n].tip_in_ct_mm[1] - samples[0].tip_in_ct_mm[1]);
    if (n > 0) {
      // No jump: at most 40 mm/s along and 8 mm/s across.
      EXPECT_LT((samples[n].tip_in_ct_mm - samples[n - 1].tip_in_ct_mm).norm(), 0.045);
    }
  }
  EXPECT_NEAR(lowest_mm, -50.0 * std::cos(4.0 * M_PI / 180.0), 0.01);
  EXPECT_NEAR(aside_mm, 1.0, 1e-6);
  EXPECT_GT(samples.front().tip_in_ct_mm[2], 2.9);
  EXPECT_GT(samples.back().tip_in_ct_mm[2], 2.9);
}

TEST(InsertionRun, MeasuresForcesAndTimes) {
  const auto samples = ScriptedInsertion();
  const InsertionRun run = Insert(Pusher{Friction}, samples);
  ASSERT_EQ(run.force_n.size(), samples.size());
  ASSERT_EQ(run.step_us.size(), samples.size());
  EXPECT_GT(math::Quantile(run.step_us, 0.5), 0.0);
  EXPECT_LE(math::Quantile(run.step_us, 0.5), math::Quantile(run.step_us, 0.999));
  EXPECT_EQ(RmsDifferenceN(run, run), 0.0);
  InsertionRun other = run;
  for (auto& force : other.force_n) force += Eigen::Vector3d(0.3, 0.0, 0.4);
  EXPECT_NEAR(RmsDifferenceN(run, other), 0.5, 1e-12);
}

TEST(WhyUnusable, IsEmptyForFriction) {
  const auto samples = ScriptedInsertion();
  EXPECT_EQ(WhyUnusable(Insert(Pusher{Friction}, samples), samples, 30.0), "");
}

TEST(WhyUnusable, FindsWhatADivergedSolverDoes) {
  const auto samples = ScriptedInsertion();
  const auto why = [&](const auto& force) {
    return WhyUnusable(Insert(Pusher{force}, samples), samples, 30.0);
  };
  EXPECT_THAT(why([](const auto& now, const auto& before) {
                return Eigen::Vector3d(Friction(now, before) * std::nan(""));
              }),
              HasSubstr("not finite"));
  EXPECT_THAT(why([](const auto& now, const auto& before) {
                return Eigen::Vector3d(100.0 * Friction(now, before));
              }),
              HasSubstr("above the largest allowed, 30"));
  EXPECT_THAT(why([](const auto& now, const auto& before) {
                return Eigen::Vector3d(-Friction(now, before));
              }),
              HasSubstr("more than it was given"));
  EXPECT_THAT(why([](const auto&, const auto&) { return Eigen::Vector3d::Zero().eval(); }),
              HasSubstr("nothing was touched"));
  EXPECT_THAT(why([](const auto& now, const auto& before) {
                return Eigen::Vector3d(Friction(now, before) + Eigen::Vector3d(0.1, 0, 0));
              }),
              HasSubstr("when the needle is out"));
}

}  // namespace
}  // namespace acus::benchmarks
