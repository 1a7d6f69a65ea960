#include "acus/rig/tracking/simulators/scripted_hand.h"

#include <gtest/gtest.h>

#include "acus/base/core/error.h"

namespace acus::simulators {
namespace {

using Eigen::Vector3d;

HandScript Script() {
  HandScript script;
  script.entry_mm = {10.0, 20.0, 30.0};
  script.target_mm = {10.0, 20.0, -30.0};
  script.rate_hz = 1000.0;
  return script;
}

Eigen::Isometry3d Needle(const ToolMotion& hand, double time_s) {
  return hand.At(std::llround(1e9 * time_s))[0].reference_from_tool.isometry();
}

TEST(ScriptedHand, LeadsTheTipToTheTargetAndBack) {
  HandScript script = Script();
  script.tremor_mm = 0.0;
  const auto hand = ScriptedHand(script, {}, 1);
  // 40 mm above the skin, then 100 mm at 10 mm/s, a hold of 2 s, and the same way back.
  EXPECT_LT((Needle(*hand, 0.0).translation() - Vector3d(10, 20, 70)).norm(), 1e-9);
  EXPECT_LT((Needle(*hand, 5.0).translation() - Vector3d(10, 20, 20)).norm(), 1e-9) << "half way";
  EXPECT_LT((Needle(*hand, 10.0).translation() - script.target_mm).norm(), 1e-9);
  EXPECT_LT((Needle(*hand, 11.9).translation() - script.target_mm).norm(), 1e-9);
  EXPECT_LT((Needle(*hand, 22.5).translation() - Vector3d(10, 20, 70)).norm(), 1e-9);
  EXPECT_LT((Needle(*hand, 34.0).translation() - script.target_mm).norm(), 1e-9) << "again";
  // The needle points along its way, the probe's beam as well.
  EXPECT_LT((Needle(*hand, 3.0).linear().col(2) - Vector3d(0, 0, -1)).norm(), 1e-12);
  const auto probe = hand->At(0)[1].reference_from_tool;
  EXPECT_LT((probe.linear().col(1) - Vector3d(0, 0, -1)).norm(), 1e-12);
  EXPECT_NEAR((probe.translation() - script.entry_mm).norm(), 25.0, 1e-9);
}

TEST(ScriptedHand, TremorHasItsSizeAndIsSmooth) {
  HandScript script = Script();
  const auto hand = ScriptedHand(script, {}, 1);
  script.tremor_mm = 0.0;
  const auto steady = ScriptedHand(script, {}, 1);
  double sum = 0.0, fastest_mm = 0.0;
  Vector3d last_mm = Vector3d::Zero();
  constexpr int kSteps = 20'000;
  for (int i = 0; i < kSteps; ++i) {
    const Vector3d tremor_mm =
        Needle(*hand, 1e-3 * i).translation() - Needle(*steady, 1e-3 * i).translation();
    sum += tremor_mm.squaredNorm() / 3.0;
    if (i > 0) fastest_mm = std::max(fastest_mm, (tremor_mm - last_mm).norm());
    last_mm = tremor_mm;
  }
  EXPECT_NEAR(std::sqrt(sum / kSteps), 0.1, 0.01);
  EXPECT_LT(fastest_mm, 0.05) << "per ms";
}

// 7 to 12 Hz; the rate of rising through zero is the root mean square of the frequencies.
TEST(ScriptedHand, TremblesAsFastAsAHand) {
  constexpr int kSeeds = 12, kSteps = 5000;
  long rises = 0;
  double sum_mm2 = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    HandScript script = Script();
    const auto hand = ScriptedHand(script, {}, static_cast<std::uint64_t>(seed));
    script.tremor_mm = 0.0;
    const auto steady = ScriptedHand(script, {}, static_cast<std::uint64_t>(seed));
    Vector3d last_mm = Vector3d::Zero();
    for (int i = 0; i < kSteps; ++i) {
      const Vector3d tremor_mm =
          Needle(*hand, 1e-3 * i).translation() - Needle(*steady, 1e-3 * i).translation();
      sum_mm2 += tremor_mm.squaredNorm() / 3.0;
      if (i > 0) rises += ((last_mm.array() < 0.0) && (tremor_mm.array() >= 0.0)).count();
      last_mm = tremor_mm;
    }
  }
  const double rate_hz = static_cast<double>(rises) / (3e-3 * kSteps * kSeeds);
  EXPECT_NEAR(rate_hz, std::sqrt((7.0 * 7.0 + 7.0 * 12.0 + 12.0 * 12.0) / 3.0), 0.8);
  EXPECT_NEAR(std::sqrt(sum_mm2 / (kSteps * kSeeds)), 0.1, 0.003) << "and as much as it says";
}

TEST(ScriptedHand, IsTheSameForTheSameSeed) {
  const auto a = ScriptedHand(Script(), {}, 7), b = ScriptedHand(Script(), {}, 7);
  const auto c = ScriptedHand(Script(), {}, 8);
  EXPECT_TRUE(Needle(*a, 3.3).matrix() == Needle(*b, 3.3).matrix());
  EXPECT_FALSE(Needle(*a, 3.3).matrix() == Needle(*c, 3.3).matrix());
}

TEST(ScriptedHand, RefusesWhatNoHandDoes) {
  HandScript script = Script();
  script.target_mm = script.entry_mm;
  EXPECT_THROW(ScriptedHand(script, {}, 1), InputError);
  script = Script();
  script.target_mm.x() = NAN;
  EXPECT_THROW(ScriptedHand(script, {}, 1), InputError);
  script = Script();
  script.insertion_mm_s = 0.0;
  EXPECT_THROW(ScriptedHand(script, {}, 1), InputError);
  script = Script();
  script.tremor_mm = -1.0;
  EXPECT_THROW(ScriptedHand(script, {}, 1), InputError);
  script = Script();
  script.rate_hz = 1e6;
  EXPECT_THROW(ScriptedHand(script, {}, 1), InputError);
}

}  // namespace
}  // namespace acus::simulators
