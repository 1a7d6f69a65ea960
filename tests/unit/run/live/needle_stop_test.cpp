// Block of layered_scene.h: skin at z = 0, bone from 60 mm for |x| < 10 mm, y > 10 mm.
#include "acus/run/live/needle_stop.h"

#include <gtest/gtest.h>

#include "support/layered_scene.h"

namespace acus::live {
namespace {

using Eigen::Vector3d;

constexpr double kBoneMm = 60.0;
const Vector3d kDown = Vector3d::UnitZ();

class NeedleStopTest : public testing::Test {
 protected:
  NeedleStop Stop(double length_mm) const {
    return {forces::TissueLookup(*scene_.labels), length_mm};
  }
  /// Moves the hand in steps, and gives the deepest place of the needle's tip, mm under the skin.
  static double Deepest(NeedleStop& stop, Vector3d hand_mm, const Vector3d& step_mm, int count,
                        StopKind by) {
    double deepest_mm = -1e9;
    for (int i = 0; i < count; ++i) {
      hand_mm += step_mm;
      last_ = stop.At(hand_mm, kDown);
      deepest_mm = std::max(deepest_mm, hand_mm.z() - last_.beyond_mm);
    }
    EXPECT_EQ(last_.by, by);
    return deepest_mm;
  }

  simulation::Scene scene_ =
      testing_support::LayeredScene(testing_support::PlanOf(true, false, false, false), false);
  static inline NeedleStop::Held last_;
};

TEST_F(NeedleStopTest, BoneStopsTheTipAtAnySpeed) {
  for (const double step_mm : {0.03, 0.5, 4.0, 19.0, 250.0}) {
    NeedleStop stop = Stop(90.0);
    stop.At({0.0, 20.0, -5.0}, kDown);
    const double deepest_mm = Deepest(stop, {0.0, 20.0, -5.0}, step_mm * kDown,
                                      static_cast<int>(300.0 / step_mm) + 1, StopKind::kBone);
    EXPECT_LE(deepest_mm, kBoneMm + 1.0 + NeedleStop::kIntoBoneMm) << step_mm;
    EXPECT_GE(deepest_mm, kBoneMm - 0.5) << step_mm;
  }
}

TEST_F(NeedleStopTest, WithdrawnOrBesideTheBoneItIsFree) {
  NeedleStop stop = Stop(90.0);
  Deepest(stop, {0.0, 20.0, 50.0}, 0.5 * kDown, 40, StopKind::kBone);
  EXPECT_EQ(Deepest(stop, {0.0, 20.0, 50.0}, -0.1 * kDown, 10, StopKind::kNone), 49.9);
  // Beside it, and from its surface to beside it.
  Deepest(stop, {0.0, 20.0, 50.0}, 0.5 * kDown, 22, StopKind::kBone);
  const double beside_mm = Deepest(stop, {0.0, 5.0, 61.0}, 0.5 * kDown, 20, StopKind::kNone);
  EXPECT_DOUBLE_EQ(beside_mm, 71.0);
}

TEST_F(NeedleStopTest, TheHubStopsAtTheSkin) {
  for (const double step_mm : {0.03, 0.5, 19.0}) {
    NeedleStop stop = Stop(30.0);
    const double deepest_mm = Deepest(stop, {20.0, 0.0, -5.0}, step_mm * kDown,
                                      static_cast<int>(80.0 / step_mm) + 1, StopKind::kHub);
    EXPECT_LE(deepest_mm, 30.0 + 1e-9);
    EXPECT_GE(deepest_mm, 29.0);
  }
}

TEST_F(NeedleStopTest, ANeedleThatIsSeenInBoneGoesNoDeeperAndComesOut) {
  NeedleStop stop = Stop(90.0);
  const Vector3d in_bone_mm(0.0, 20.0, 70.0);
  EXPECT_EQ(stop.At(in_bone_mm, kDown).beyond_mm, 0.0);
  EXPECT_DOUBLE_EQ(Deepest(stop, in_bone_mm, 0.5 * kDown, 20, StopKind::kBone), 70.0);
  Deepest(stop, in_bone_mm, -0.5 * kDown, 30, StopKind::kNone);
  EXPECT_EQ(last_.beyond_mm, 0.0);
}

}  // namespace
}  // namespace acus::live
