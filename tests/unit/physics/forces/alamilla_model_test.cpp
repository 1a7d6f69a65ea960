#include "acus/physics/forces/models/alamilla_model.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <numbers>

#include "acus/data/volume/labels.h"
#include "references/closed_loop.h"
#include "support/force_scenes.h"

namespace acus::forces {
namespace {

using testing_support::DrivenAlamilla;
using testing_support::LayeredBodyField;
using testing_support::ShippedTable;
using testing_support::Trocar18G;

class AlamillaTest : public testing::Test {
 protected:
  AlamillaTest() : table(ShippedTable("alamilla.json")) {}

  /// Along z from where it is, at a constant speed.
  const NeedleForce& MoveTo(double z_mm, double speed_mm_per_s = 8.0) {
    const double step_mm = speed_mm_per_s * 0.001;
    while (std::abs(z_mm - place_mm.z()) > 1e-9) {
      place_mm.z() += std::clamp(z_mm - place_mm.z(), -step_mm, step_mm);
      StepHere();
    }
    return driven.last;
  }
  const NeedleForce& StepHere() {
    time_s += 0.001;
    driven.Step(time_s, place_mm);
    if (driven.last.event != NeedleEvent::kNone) events.push_back(driven.last.event);
    return driven.last;
  }

  ForceTable table;
  AlamillaModel model{table, Trocar18G()};
  LayeredBodyField body{
      {{0.0, "skin", 20}, {12.0, "muscle", 55}, {40.0, "tendon", 90}, {60.0, "bone", 900}}};
  DrivenAlamilla driven{model, body};
  Eigen::Vector3d place_mm{0.0, 0.0, -1.0};
  double time_s = 0.0;
  std::vector<NeedleEvent> events;
};

// Eq. 2 with the paper's coefficients, up to table II's 1 N at 10 mm; then the sharp drop.
TEST_F(AlamillaTest, PolynomialUntilThePuncture) {
  MoveTo(5.0);
  EXPECT_NEAR(driven.last.AxialN(), 0.048 * 5.0 + 0.0052 * 25.0, 1e-3);
  MoveTo(9.9);
  EXPECT_NEAR(driven.last.AxialN(), 0.048 * 9.9 + 0.0052 * 9.9 * 9.9, 2e-3);
  EXPECT_FALSE(driven.state.pierced);
  while (driven.last.event != NeedleEvent::kPuncture) {
    place_mm.z() += 0.008;
    StepHere();
  }
  EXPECT_NEAR(place_mm.z(), 10.0, 0.02);
  EXPECT_EQ(driven.last.AxialN(), 0.0);
  EXPECT_TRUE(driven.state.pierced);
}

// Eq. 3: K_t = 0.25 N/mm up to the tissue's force of table II, and the same drawn back.
TEST_F(AlamillaTest, TrackingWallCutsAndWithdraws) {
  MoveTo(10.1);
  const double start_mm = driven.state.wall.wall_mm;
  MoveTo(11.5);
  EXPECT_NEAR(driven.last.cutting_n, 0.25 * (11.5 - start_mm), 5e-3);
  MoveTo(30.0);
  EXPECT_NEAR(driven.last.cutting_n, 2.0, 1e-9);
  MoveTo(26.0);
  EXPECT_NEAR(driven.last.cutting_n, 1.0, 1e-3);
  MoveTo(13.0);
  EXPECT_NEAR(driven.last.cutting_n, -2.0, 1e-3);
  EXPECT_LT(driven.last.friction_n, 0.0);
  place_mm.z() = 5.0;
  MoveTo(-1.0);
  EXPECT_EQ(driven.last.AxialN(), 0.0);
  EXPECT_EQ(events.back(), NeedleEvent::kWithdrawal);
}

TEST_F(AlamillaTest, EachLayerHoldsTheNeedleDuringWithdrawalByItsOwnForce) {
  MoveTo(55.0);
  EXPECT_NEAR(driven.last.cutting_n, 2.5, 1e-9);
  MoveTo(41.0, 40.0);
  MoveTo(30.0, 40.0);
  EXPECT_NEAR(driven.last.cutting_n, -2.0, 1e-9);  // Muscle, not tendon.
  MoveTo(9.0, 40.0);
  EXPECT_NEAR(driven.last.cutting_n, -1.0, 1e-9);  // Skin.
}

// K_t of eq. 3 is that of the tissue where its row has one.
TEST_F(AlamillaTest, EachTissueMayHaveItsOwnStiffness) {
  ForceTable own_table = table;
  own_table.tissue[volume::LabelOf("muscle")].cutting_stiffness_n_per_mm = 1.0;
  const AlamillaModel own(own_table, Trocar18G());
  LayeredBodyField muscle({{0.0, "skin", 20}, {12.0, "muscle", 55}});
  DrivenAlamilla drive{own, muscle};
  double t = 0.0;
  double z = -1.0;
  for (; z < 30.0; z += 0.008) drive.Step(t += 0.001, {0, 0, z});
  EXPECT_NEAR(drive.last.cutting_n, 2.0, 1e-9);
  for (; z > 29.0; z -= 0.008) drive.Step(t += 0.001, {0, 0, z});
  EXPECT_NEAR(drive.last.cutting_n, 2.0 - 1.0 * (drive.state.channel_mm - drive.last.depth_mm),
              0.02);
}

// Eq. 6: F_n (g(v) + sigma2 v) with F_n the tissue's cutting force.
TEST_F(AlamillaTest, FrictionIsLuGreTimesTheCuttingForce) {
  for (const double speed : {4.0, 8.0, 40.0}) {
    MoveTo(20.0, speed);
    MoveTo(38.0, speed);
    const double g = 1.763 + (0.052 - 1.763) * std::exp(-0.075 * speed);
    EXPECT_NEAR(driven.last.friction_n, 2.0 * (g + 2.04e-3 * speed), 5e-3) << speed;
    EXPECT_NEAR(driven.last.force_in_ct_n.z(), -driven.last.AxialN(), 1e-12);
  }
}

TEST_F(AlamillaTest, StandingStillKeepsTheForce) {
  MoveTo(30.0);
  StepHere();
  for (int i = 0; i < 500; ++i) StepHere();  // The filtered speed fades.
  const double held_n = driven.last.AxialN();
  for (int i = 0; i < 5000; ++i) ASSERT_NEAR(StepHere().AxialN(), held_n, 1e-9);
}

TEST_F(AlamillaTest, ClampsTheTurnedNeedleUntilItIsPushedOn) {
  MoveTo(30.0);
  EXPECT_NEAR(driven.last.torque_in_ct_n_mm.norm(), 0.0, 1e-9);
  const double angle = 0.1;
  for (int i = 1; i <= 200; ++i) {
    driven.axis = {std::sin(angle * i / 200), 0.0, std::cos(angle * i / 200)};
    StepHere();
  }
  StepHere();
  EXPECT_NEAR(driven.last.torque_in_ct_n_mm.y(), -1000.0 * angle, 1e-6);
  // On along the new axis by 6 mm; the play of 0.5 mm is taken up already, as it was going in.
  for (int i = 0; i < 3000; ++i) {
    place_mm += 0.002 * driven.axis;
    StepHere();
  }
  const double left = std::exp(-6.0 / 5.0);
  EXPECT_NEAR(driven.last.torque_in_ct_n_mm.norm(), 1000.0 * angle * left, 0.2);
  EXPECT_LT(driven.last.lateral_n, 0.12);
  EXPECT_NEAR(driven.state.path.direction_in_ct.x(), std::sin(angle * (1.0 - left)), 2e-3);
  EXPECT_NEAR(driven.last.depth_mm, 36.0, 0.1);
}

TEST_F(AlamillaTest, PushesTheTipBackToItsLine) {
  MoveTo(30.0);
  place_mm.x() += 5.0;
  StepHere();
  StepHere();
  EXPECT_NEAR(driven.last.force_in_ct_n.x(), -0.2 * 5.0, 1e-6);
  EXPECT_NEAR(driven.last.lateral_n, 1.0, 1e-6);
  place_mm.x() += 500.0;
  StepHere();
  StepHere();
  EXPECT_NEAR(driven.last.lateral_n, 3.0, 1e-6);  // The limit.
}

TEST_F(AlamillaTest, KnocksOnBoneAndIsHeldByTableTwosForce) {
  MoveTo(59.9, 50.0);
  while (driven.last.event != NeedleEvent::kBoneContact) {
    place_mm.z() += 0.05;
    StepHere();
  }
  EXPECT_TRUE(driven.state.knock.running);
  EXPECT_NEAR(driven.state.knock.impact_mm_per_s, 50.0, 2.0);
  double peak_n = 0.0;
  for (int i = 0; i < 6; ++i) {
    place_mm.z() += 0.05;
    StepHere();
    EXPECT_GT(driven.last.bone_n,
              table.settings.bone.ForceN(driven.last.bone_penetration_mm, 50.0) - 1e-9);
    peak_n = std::max(peak_n, driven.last.bone_n);
  }
  EXPECT_GT(peak_n, 1.0);
  MoveTo(70.0);
  EXPECT_NEAR(driven.last.bone_n, 4.0, 1e-9);
  EXPECT_NEAR(driven.last.depth_mm, 60.0, 0.05);
}

// Eq. 1 as printed: (soft) the sum, (hard) hardContact alone, which is eq. 12 and then nothing.
TEST_F(AlamillaTest, AsPrintedOnlyBoneActsOnBone) {
  ForceTable printed_table = table;
  printed_table.alamilla.only_bone_on_bone = true;
  printed_table.alamilla.hard_contact.without_account = true;
  const AlamillaModel printed(printed_table, Trocar18G());
  DrivenAlamilla drive{printed, body};
  double t = 0.0;
  double z = -1.0;
  for (; z < 59.5; z += 0.008) drive.Step(t += 0.001, {0, 0, z});
  EXPECT_NEAR(drive.last.cutting_n, 2.5, 1e-9);
  while (!drive.state.on_bone) drive.Step(t += 0.001, {0, 0, z += 0.008});
  const double impact_mm_per_s = drive.state.knock.impact_mm_per_s;
  EXPECT_NEAR(impact_mm_per_s, 8.0, 0.3);  // Filtered.
  double lowest_n = 0.0;
  for (int i = 2; i < 55; ++i) {  // The step of the contact was the first.
    drive.Step(t += 0.001, {0, 0, z += 0.008});
    const double since_s = 0.001 * i;
    const double knock_n = 0.0199 * impact_mm_per_s * std::exp(std::log(0.01) * since_s / 0.055) *
                           std::sin(2.0 * std::numbers::pi * 55.0 * since_s);
    EXPECT_NEAR(drive.last.bone_n, knock_n, 1e-9) << i;
    EXPECT_EQ(drive.last.force_in_ct_n, Eigen::Vector3d(0, 0, -drive.last.bone_n));
    lowest_n = std::min(lowest_n, drive.last.bone_n);
  }
  EXPECT_LT(lowest_n, -0.02);  // It pulls, too.
  for (; z < 61.0; z += 0.008) drive.Step(t += 0.001, {0, 0, z});
  EXPECT_EQ(drive.last.force_in_ct_n.norm(), 0.0);
  for (; z > 58.0; z -= 0.008) drive.Step(t += 0.001, {0, 0, z});
  EXPECT_EQ(drive.last.bone_n, 0.0);
  EXPECT_NE(drive.last.AxialN(), 0.0);
  MoveTo(61.0);
  EXPECT_GT(driven.last.AxialN(), driven.last.bone_n + 1.0);  // The default keeps cutting.
}

TEST_F(AlamillaTest, EventsComeInTheOrderOfTheLayers) {
  MoveTo(62.0);
  using enum NeedleEvent;
  EXPECT_THAT(events,
              testing::ElementsAre(kContact, kPuncture, kInterface, kInterface, kBoneContact));
  events.clear();
  MoveTo(50.0);
  MoveTo(45.0);
  EXPECT_THAT(events, testing::ElementsAre(kBoneRelease));
}

TEST_F(AlamillaTest, AStifferTissueTakesTheForceOver) {
  table.tissue[volume::LabelOf("tendon")].cutting_stiffness_n_per_mm = 2.0;
  const AlamillaModel stiff(table, Trocar18G());
  DrivenAlamilla drive{stiff, body};
  double t = 0.0;
  double before_n = 0.0;
  for (double z = -1.0; z < 50.0; z += 0.008) {
    const NeedleForce& out = drive.Step(t += 0.001, {0, 0, z});
    if (z > 11.0) {
      ASSERT_LT(std::abs(out.cutting_n - before_n), 0.02) << z;
    }
    before_n = out.cutting_n;
  }
  EXPECT_NEAR(before_n, 2.5, 1e-9);
}

TEST_F(AlamillaTest, LostAndBadSamplesAreThoseOfTheLayeredModel) {
  MoveTo(30.0);
  const double held_n = driven.last.AxialN();
  NeedleInput lost{time_s + 0.09, {NAN, NAN, NAN}, {NAN, 0, 0}, 0, false};
  EXPECT_EQ(model.Step(driven.state, lost).AxialN(), held_n);
  lost.time_s = time_s + 0.2;
  EXPECT_NEAR(model.Step(driven.state, lost).AxialN(), 0.5 * held_n, 1e-9);
  const NeedleInput bad{time_s + 0.3, {NAN, 0, 25}, {0, 0, 1}, 3, true};
  EXPECT_EQ(model.Step(driven.state, bad).force_in_ct_n.norm(), 0.0);
  EXPECT_EQ(driven.state.num_rejected, 1);
  const NeedleInput late{time_s, {0, 0, 90}, {0, 0, 1}, 3, true};
  model.Step(driven.state, late);
  EXPECT_EQ(driven.state.num_time_back, 1);
}

TEST_F(AlamillaTest, TheDirectMethodIsTheWholeForceWhicheverWayTheTipMoves) {
  ForceTable direct_table = table;
  direct_table.alamilla.direct_method = true;
  const AlamillaModel direct(direct_table, Trocar18G());
  DrivenAlamilla drive{direct, body};
  double t = 0.0;
  double z = -1.0;
  for (; z < 25.0; z += 0.008) drive.Step(t += 0.001, {0, 0, z});
  EXPECT_EQ(drive.last.cutting_n, table.tissue[volume::LabelOf("muscle")].cutting_n);
  for (; z > 20.0; z -= 0.008) drive.Step(t += 0.001, {0, 0, z});
  EXPECT_EQ(drive.last.cutting_n, table.tissue[volume::LabelOf("muscle")].cutting_n);
}

// Figures 14 and 15: a hand that rests at the skin's wall of 1 N, through a nick, with 0.6 N; a
// light device.
TEST_F(AlamillaTest, AHandAtTheWallChattersByTheDirectMethodOnly) {
  const auto chatter_n = [&](bool direct_method) {
    ForceTable with_nick = table;
    with_nick.alamilla.direct_method = direct_method;
    with_nick.nick = {Eigen::Vector3d::Zero(), 3.0};
    const AlamillaModel wall(with_nick, Trocar18G());
    DrivenAlamilla drive{wall, body};
    Hand hand;
    hand.wants_in_ct_mm = [](double time) {
      const double s = std::clamp(time, 0.0, 1.0);
      return Eigen::Vector3d(0, 0, -2.0 + 3.5 * s * s * (3.0 - 2.0 * s));
    };
    const LoopResult result = RunClosedLoop(
        {.dry_friction_n = 0.05}, hand,
        [&](double time, const Eigen::Vector3d& tip_mm) {
          return drive.Step(time, tip_mm).force_in_ct_n;
        },
        6.0);
    return result.ChatterN(2.0, 6.0);
  };
  EXPECT_GT(chatter_n(true), 0.2);
  EXPECT_LT(chatter_n(false), 0.005);
}

}  // namespace
}  // namespace acus::forces
