#include "acus/physics/tissue/sample_gate.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace acus::tissue {
namespace {

using Verdict = SampleGate::Verdict;
using forces::NeedleEvent;

ToolSample At(double time_s) {
  ToolSample sample;
  sample.time_s = time_s;
  return sample;
}

TEST(SampleGate, StepsOnValidSamplesOnly) {
  SampleGate gate;
  EXPECT_EQ(gate.Judge(At(1.0)), Verdict::kStep);
  gate.Accept(At(1.0), {});
  EXPECT_EQ(gate.Judge(At(1.0)), Verdict::kHold);
  EXPECT_EQ(gate.Judge(At(0.5)), Verdict::kHold);
  EXPECT_EQ(gate.num_time_back, 2);
  EXPECT_EQ(gate.time_s, 1.0);
  EXPECT_EQ(gate.Judge(At(1.001)), Verdict::kStep);
  EXPECT_EQ(gate.num_rejected, 0);
}

TEST(SampleGate, RefusesInvalidDataAndCountsIt) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  SampleGate gate;
  int rejected = 0;
  double time_s = 0.0;
  for (const double bad : {nan, inf, -inf}) {
    ToolSample sample = At(time_s += 1.0);
    sample.tip_in_ct_mm.y() = bad;
    EXPECT_EQ(gate.Judge(sample), Verdict::kZero);
    sample = At(time_s += 1.0);
    sample.axis_in_ct.x() = bad;
    EXPECT_EQ(gate.Judge(sample), Verdict::kZero);
    EXPECT_EQ(gate.Judge(At(bad)), Verdict::kZero);
    EXPECT_EQ(gate.num_rejected, rejected += 3);
  }
  ToolSample sample = At(time_s += 1.0);
  sample.axis_in_ct.setZero();
  EXPECT_EQ(gate.Judge(sample), Verdict::kZero);
  sample = At(time_s += 1.0);
  sample.tip_in_ct_mm.z() = 2e5;
  EXPECT_EQ(gate.Judge(sample), Verdict::kZero);
  EXPECT_FALSE(gate.started);
}

TEST(SampleGate, HoldsALostNeedlesForceThenLetsGo) {
  forces::ForceSettings settings;
  settings.invalid_hold_s = 0.1;
  settings.invalid_ramp_s = 0.2;
  SampleGate gate;
  ToolSample lost = At(0.0);
  lost.needle_valid = false;
  EXPECT_EQ(gate.Judge(lost), Verdict::kZero);  // There is nothing to hold yet.
  forces::NeedleForce force;
  force.cutting_n = 2.0;
  force.force_in_ct_n = Eigen::Vector3d(0, 0, -2);
  force.event = NeedleEvent::kPuncture;
  ASSERT_EQ(gate.Judge(At(1.0)), Verdict::kStep);
  gate.Accept(At(1.0), force);
  for (const auto& [time_s, share] :
       {std::pair{1.05, 1.0}, {1.1, 1.0}, {1.2, 0.5}, {1.3, 0.0}, {9.0, 0.0}}) {
    lost.time_s = time_s;
    EXPECT_EQ(gate.Judge(lost), Verdict::kHold);
    const forces::NeedleForce held = gate.Held(settings);
    EXPECT_NEAR(held.cutting_n, 2.0 * share, 1e-12);
    EXPECT_NEAR(held.force_in_ct_n.z(), -2.0 * share, 1e-12);
    EXPECT_EQ(held.event, NeedleEvent::kNone);
  }
}

TEST(LimitTo, ScalesAllPartsAlike) {
  forces::NeedleForce force;
  force.cutting_n = 3.0;
  force.friction_n = 1.0;
  force.lateral_n = 3.0;
  force.force_in_ct_n = Eigen::Vector3d(3, 0, -4);
  LimitTo(force, 6.0);
  EXPECT_EQ(force.cutting_n, 3.0);
  LimitTo(force, 2.5);
  EXPECT_DOUBLE_EQ(force.cutting_n, 1.5);
  EXPECT_DOUBLE_EQ(force.friction_n, 0.5);
  EXPECT_DOUBLE_EQ(force.lateral_n, 1.5);
  EXPECT_DOUBLE_EQ(force.force_in_ct_n.norm(), 2.5);
}

TEST(FirstOf, ReportsTheMostImportantEvent) {
  using enum NeedleEvent;
  EXPECT_EQ(FirstOf(kNone, kNone), kNone);
  EXPECT_EQ(FirstOf(kInterface, kPuncture), kPuncture);
  EXPECT_EQ(FirstOf(kPuncture, kBoneContact), kBoneContact);
  EXPECT_EQ(FirstOf(kContact, kInterface), kContact);
  EXPECT_EQ(FirstOf(kNone, kWithdrawal), kWithdrawal);
}

}  // namespace
}  // namespace acus::tissue
