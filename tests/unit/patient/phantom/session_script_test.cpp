#include "acus/patient/phantom/hands/session_script.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/math/rigid.h"
#include "unit/patient/phantom/presets.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;
using testing::ElementsAre;

/// The demo's sessions, played once for all tests.
struct Played {
  explicit Played(const char* preset) : c(preset, 1) {
    RunContext context;
    context.seed = 1;
    scripted = PlayScript(c.field, c.plan, c.config.session, reference_from_ct(), context);
  }
  const Eigen::Isometry3d& reference_from_ct() const { return c.config.markers.reference_from_ct; }
  Vector3d TipInCt(std::size_t i) const {
    const Vector3d tip = scripted.session.needle[i].reference_from_tool.translation();
    return reference_from_ct().inverse() * tip;
  }
  Case c;
  ScriptedSession scripted;
};

const Played& Session(const std::string& preset) {
  static const Played kLumbar("lumbar"), kLiver("liver");
  return preset == "lumbar" ? kLumbar : kLiver;
}

class Sessions : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Demo, Sessions, testing::Values("lumbar", "liver"));

TEST_P(Sessions, RunAtOneKilohertzForAboutHalfAMinute) {
  const auto& session = Session(GetParam()).scripted.session;
  ASSERT_EQ(session.needle.size(), session.probe.size());
  for (std::size_t i = 0; i < session.needle.size(); ++i) {
    ASSERT_EQ(session.needle[i].time_ns, static_cast<std::int64_t>(i) * 1'000'000);
    ASSERT_EQ(session.probe[i].time_ns, session.needle[i].time_ns);
    ASSERT_TRUE(math::IsRigid(session.needle[i].reference_from_tool.matrix(), 1e-9));
    ASSERT_TRUE(math::IsRigid(session.probe[i].reference_from_tool.matrix(), 1e-9));
  }
  EXPECT_GT(session.needle.size(), 25'000U);
  EXPECT_LT(session.needle.size(), 35'000U);
}

TEST_P(Sessions, MoveAsAHandCan) {
  const auto& session = Session(GetParam()).scripted.session;
  for (const auto* stream : {&session.needle, &session.probe}) {
    double speed = 0.0, acceleration = 0.0;
    for (std::size_t i = 2; i < stream->size(); ++i) {
      const Vector3d a = (*stream)[i - 2].reference_from_tool.translation();
      const Vector3d b = (*stream)[i - 1].reference_from_tool.translation();
      const Vector3d c = (*stream)[i].reference_from_tool.translation();
      speed = std::max(speed, (c - b).norm() * 1e3);
      acceleration = std::max(acceleration, (c - 2 * b + a).norm() * 1e6);
    }
    EXPECT_LT(speed, 150.0);          // mm/s: a quick withdrawal.
    EXPECT_LT(acceleration, 6000.0);  // mm/s^2, 0.6 g, most of it tremor.
    EXPECT_GT(speed, 20.0);
  }
}

TEST_P(Sessions, AreInOrderAndComplete) {
  const auto& events = Session(GetParam()).scripted.events;
  std::vector<std::string> story;
  for (const NeedleEvent& event : events) {
    if (event.kind != "puncture") story.push_back(event.kind);
  }
  EXPECT_THAT(story,
              ElementsAre("contact", "bone_touch", "redirect", "target_reached", "withdrawn"));
  for (std::size_t i = 1; i < events.size(); ++i) EXPECT_LE(events[i - 1].time_s, events[i].time_s);
  std::vector<std::string> entered;  // After the redirection.
  bool redirected = false;
  for (const NeedleEvent& event : events) {
    if (redirected && event.kind == "puncture") entered.push_back(event.tissue);
    redirected = redirected || event.kind == "redirect";
  }
  const bool lumbar = std::string(GetParam()) == "lumbar";
  EXPECT_EQ(entered.back(), lumbar ? "spinal_canal" : "lesion");
  EXPECT_EQ(std::ranges::count(entered, lumbar ? "ligament" : "liver"), 1);
}

TEST_P(Sessions, HaveEventsWhereTheAnatomySaysSo) {
  const Played& played = Session(GetParam());
  for (const NeedleEvent& event : played.scripted.events) {
    const auto i = static_cast<std::size_t>(std::lround(event.time_s * 1000.0));
    if (event.kind != "contact" && event.kind != "puncture" && event.kind != "bone_touch") continue;
    EXPECT_EQ(played.c.field.LabelAt(played.TipInCt(i)), volume::LabelOf(event.tissue))
        << event.time_s;
    // It was elsewhere less than a tremor's period before.
    bool elsewhere = false;
    for (std::size_t back = 1; back < 120; ++back) {
      elsewhere = elsewhere ||
                  played.c.field.LabelAt(played.TipInCt(i - back)) != volume::LabelOf(event.tissue);
    }
    EXPECT_TRUE(elsewhere) << event.time_s;
  }
}

TEST_P(Sessions, NeverGoDeeperIntoBoneThanTheyPress) {
  const Played& played = Session(GetParam());
  double deepest_mm = 0.0;
  const Vector3d direction =
      Eigen::AngleAxisd(*played.c.plan.bone_angle_rad, played.c.plan.bone_axis) *
      played.c.plan.direction;
  for (std::size_t i = 0; i < played.scripted.session.needle.size(); ++i) {
    if (played.c.field.LabelAt(played.TipInCt(i)) != volume::LabelOf("bone")) continue;
    const double depth = (played.TipInCt(i) - played.c.plan.entry_ct_mm).dot(direction);
    deepest_mm = std::max(deepest_mm, depth - played.c.plan.bone_depth_mm);
  }
  EXPECT_GT(deepest_mm, 0.0);
  EXPECT_LT(deepest_mm, played.c.config.session.bone_press_mm + 0.15);  // And tremor.
}

TEST_P(Sessions, ReachTheTarget) {
  const Played& played = Session(GetParam());
  for (const NeedleEvent& event : played.scripted.events) {
    if (event.kind != "target_reached") continue;
    const auto i = static_cast<std::size_t>(std::lround(event.time_s * 1000.0));
    EXPECT_LT((played.TipInCt(i) - played.c.target_ct_mm).norm(), 0.3);
  }
}

TEST_P(Sessions, KeepTheProbeOnTheSkinOnceItHasLanded) {
  const Played& played = Session(GetParam());
  const auto& probe = played.scripted.session.probe;
  for (std::size_t i = 1500; i < probe.size(); i += 7) {
    const Eigen::Isometry3d ct_from_probe =
        played.reference_from_ct().inverse() * probe[i].reference_from_tool.isometry();
    const double gap = played.c.field.SkinDistanceMm(ct_from_probe.translation());
    ASSERT_GE(gap, 0.0) << "at " << i << " ms";
    ASSERT_LE(gap, 1.0) << "at " << i << " ms";
    ASSERT_LT(played.c.field.SkinDistanceMm(ct_from_probe * Vector3d(0, 10, 0)), 0.0)
        << "the beam must go into the body";
  }
  EXPECT_GT(played.c.field.SkinDistanceMm(played.reference_from_ct().inverse() *
                                          probe[0].reference_from_tool.translation()),
            15.0);
}

TEST_P(Sessions, HoldTheNeedleInTheImagePlaneAtTheEnd) {
  const Played& played = Session(GetParam());
  for (const NeedleEvent& event : played.scripted.events) {
    if (event.kind != "target_reached") continue;
    const auto i = static_cast<std::size_t>(std::lround(event.time_s * 1000.0));
    const Eigen::Isometry3d probe_from_needle =
        played.scripted.session.probe[i].reference_from_tool.inverse() *
        played.scripted.session.needle[i].reference_from_tool.isometry();
    for (const double back : {0.0, -20.0, -40.0}) {
      const Vector3d shaft = probe_from_needle * Vector3d(0, 0, back);
      EXPECT_LT(std::abs(shaft.z()), 2.5) << "out of plane, " << back << " mm behind the tip";
      EXPECT_GT(shaft.y(), 0.0) << "in front of the face";
    }
  }
}

TEST(PlayScript, IsMadeByItsSeedAndLeavesOutBoneIfThereIsNone) {
  const Case c("lumbar", 1);
  SessionSettings settings = c.config.session;
  InsertionPlan plan = c.plan;
  plan.bone_angle_rad.reset();
  RunContext one, two;
  one.seed = 1;
  two.seed = 2;
  const Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  const auto a = PlayScript(c.field, plan, settings, pose, one);
  const auto again = PlayScript(c.field, plan, settings, pose, one);
  const auto b = PlayScript(c.field, plan, settings, pose, two);
  EXPECT_EQ(a.session.needle[999].reference_from_tool,
            again.session.needle[999].reference_from_tool);
  EXPECT_FALSE(a.session.needle[999].reference_from_tool ==
               b.session.needle[999].reference_from_tool);
  for (const NeedleEvent& event : a.events) EXPECT_NE(event.kind, "bone_touch");
}

TEST(PlayScript, RefusesScriptsThatMakeNoSense) {
  const Case c("lumbar", 1);
  const Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  SessionSettings settings = c.config.session;
  settings.needle = {};
  EXPECT_THROW(PlayScript(c.field, c.plan, settings, pose, {}), InputError);
  settings.needle = {{.to = NeedleMove::To::kStart}};  // Already there.
  EXPECT_THROW(PlayScript(c.field, c.plan, settings, pose, {}), InputError);
  settings.needle = {{.to = NeedleMove::To::kDepth, .depth_mm = 250.0}};
  EXPECT_THROW(PlayScript(c.field, c.plan, settings, pose, {}), InputError);
  settings = c.config.session;
  settings.probe.ahead_mm = 2000.0;
  EXPECT_THROW(PlayScript(c.field, c.plan, settings, pose, {}), NoAnswerError);
}

}  // namespace
}  // namespace acus::phantom
