#include "acus/physics/forces/models/needle_force.h"

#include <cmath>
#include <gmock/gmock.h>

#include "layered_body.h"

namespace acus::forces {
namespace {

const volume::Label kSkin = volume::LabelOf("skin");
const volume::Label kFat = volume::LabelOf("fat");
const volume::Label kLiver = volume::LabelOf("liver");
const volume::Label kVessel = volume::LabelOf("vessel");
const volume::Label kBone = volume::LabelOf("bone");

class NeedleForceTest : public testing::Test {
 protected:
  NeedleForceModel model{SimpleTable(), Trocar()};
  const LayeredBody fat_and_liver{{{0.0, kSkin}, {2.0, kFat}, {30.0, kLiver}}};
  Insertion insertion{model, fat_and_liver};
};

TEST_F(NeedleForceTest, PressesOnTheSkinByThePolynomialAndDropsAtPuncture) {
  insertion.MoveTo(4.0);
  // Contact is half way between the samples around z = 0, 0.005 mm apart.
  EXPECT_NEAR(insertion.last.AxialN(), 0.1 * 4.0 + 0.05 * 16.0, 0.003);
  EXPECT_EQ(insertion.last.cutting_n, 0.0);
  EXPECT_EQ(insertion.last.friction_n, 0.0);
  EXPECT_EQ(insertion.Count(NeedleEvent::kContact), 1);
  const double puncture_mm = PuncturePolynomial{0.1, 0.05, 2.1}.PunctureDepthMm();
  double peak_n = 0.0;
  while (insertion.Count(NeedleEvent::kPuncture) == 0) {
    peak_n = insertion.last.AxialN();
    insertion.StepTo(insertion.z_mm + 0.005);
  }
  EXPECT_NEAR(peak_n, 2.1, 0.01);
  EXPECT_NEAR(insertion.z_mm, puncture_mm, 0.011);
  EXPECT_NEAR(insertion.last.AxialN(), 0.4, 1e-9);  // Fat cuts at 0.4 N; no friction yet.
}

// Behind the nick all is as without it; beside it the skin resists as ever.
TEST_F(NeedleForceTest, InANickTheSkinDoesNotResist) {
  ForceTable table = SimpleTable();
  table.nick = {Eigen::Vector3d::Zero(), 2.0};
  const NeedleForceModel with_nick(table, Trocar());
  Insertion nicked{with_nick, fat_and_liver};
  double largest_n = 0.0;
  while (nicked.z_mm < 5.0) {
    nicked.StepTo(nicked.z_mm + 0.005);
    largest_n = std::max(largest_n, nicked.last.AxialN());
  }
  // Cutting and friction of the skin are left; its membrane takes 2.1 N.
  EXPECT_LT(largest_n, table.tissue[kSkin].cutting_n + 2.0 * 0.03 + 0.01);
  EXPECT_EQ(nicked.Count(NeedleEvent::kPuncture), 0);
  EXPECT_EQ(nicked.Count(NeedleEvent::kContact), 1);
  nicked.MoveTo(45.0);
  insertion.MoveTo(45.0);
  EXPECT_EQ(nicked.Count(NeedleEvent::kPuncture), insertion.Count(NeedleEvent::kPuncture) - 1);
  EXPECT_NEAR(nicked.last.AxialN(), insertion.last.AxialN(), 2e-4);

  table.nick.at_in_ct_mm.x() = 2.1;
  const NeedleForceModel elsewhere(table, Trocar());
  Insertion beside{elsewhere, fat_and_liver};
  Insertion without{model, fat_and_liver};
  beside.MoveTo(25.0);
  without.MoveTo(25.0);
  EXPECT_EQ(beside.last.force_in_ct_n, without.last.force_in_ct_n);
  EXPECT_EQ(beside.Count(NeedleEvent::kPuncture), 1);
}

// Bovine liver: 0.016 N/mm on the way in, 0.0105 out. The way in is the same to the bit.
TEST_F(NeedleForceTest, WithdrawalHasItsOwnFriction) {
  ForceTable table = SimpleTable();
  table.tissue[kFat].withdrawal_friction_n_per_mm = 0.004;
  const NeedleForceModel apart(table, Trocar());
  Insertion drive{apart, fat_and_liver};
  drive.MoveTo(25.0);
  insertion.MoveTo(25.0);
  EXPECT_EQ(drive.last.force_in_ct_n, insertion.last.force_in_ct_n);
  drive.MoveTo(15.0);
  insertion.MoveTo(15.0);
  EXPECT_NEAR(insertion.last.friction_n, -(0.03 * 2.0 + 0.01 * 13.0), 1e-3);
  EXPECT_NEAR(drive.last.friction_n, -(0.03 * 2.0 + 0.004 * 13.0), 1e-3);
  // Round and round in the channel: the bristles give back what they hold, and no more.
  const double before_n_mm = drive.work_n_mm;
  const double held_n_mm =
      0.5 * std::abs(drive.last.friction_n) * table.settings.friction_buildup_mm;
  for (int i = 0; i < 20; ++i) {
    drive.MoveTo(15.0 + 0.1 * i);
    EXPECT_GE(drive.work_n_mm, before_n_mm - held_n_mm) << i;
    drive.MoveTo(15.0);
    EXPECT_GE(drive.work_n_mm, before_n_mm - held_n_mm) << i;
  }
  EXPECT_GT(drive.work_n_mm, before_n_mm + 1.0);
}

// On the way in it is not felt; on the way out it is shared by the tissues around the last 5 mm.
TEST_F(NeedleForceTest, ATissueHoldsTheTipThatIsWithdrawnFromIt) {
  ForceTable table = SimpleTable();
  table.tissue[kFat].withdrawal_tip_n = 0.4;
  const NeedleForceModel holding(table, Trocar());
  Insertion drive{holding, fat_and_liver};
  drive.MoveTo(25.0);
  insertion.MoveTo(25.0);
  EXPECT_EQ(drive.last.force_in_ct_n, insertion.last.force_in_ct_n);
  for (const auto& [depth_mm, held_n] :
       {std::pair{15.0, 0.4}, {4.5, 0.2}, {2.5, 0.04}, {1.0, 0.0}}) {
    drive.MoveTo(depth_mm);
    insertion.MoveTo(depth_mm);
    EXPECT_NEAR(drive.last.friction_n, insertion.last.friction_n - held_n, 1e-3) << depth_mm;
  }
  // To and fro where the tip is half in the fat: never more work out than the bristles hold.
  drive.MoveTo(4.5);
  const double before_n_mm = drive.work_n_mm;
  const double held_n_mm =
      0.5 * std::abs(drive.last.friction_n) * table.settings.friction_buildup_mm;
  for (int i = 0; i < 20; ++i) {
    drive.MoveTo(4.5 + 0.1 * i);
    EXPECT_GE(drive.work_n_mm, before_n_mm - held_n_mm) << i;
    drive.MoveTo(4.5);
    EXPECT_GE(drive.work_n_mm, before_n_mm - held_n_mm) << i;
  }
}

// Out through the interface and in again: told apart from the first time, and once each time.
TEST_F(NeedleForceTest, InterfacesInTheChannelAreEventsOfTheirOwn) {
  insertion.MoveTo(45.0);
  EXPECT_EQ(insertion.Count(NeedleEvent::kChannelInterface), 0);
  const int fresh = insertion.Count(NeedleEvent::kInterface);
  EXPECT_EQ(fresh, 2);  // Skin to fat, fat to liver.
  for (int i = 1; i <= 3; ++i) {
    insertion.MoveTo(20.0);
    EXPECT_EQ(insertion.Count(NeedleEvent::kChannelInterface), 2 * i - 1);
    insertion.MoveTo(44.0);
    EXPECT_EQ(insertion.Count(NeedleEvent::kChannelInterface), 2 * i);
  }
  for (int i = 0; i < 500; ++i) insertion.StepTo(30.0 + 0.05 * std::sin(0.3 * i));  // A tremor.
  EXPECT_EQ(insertion.Count(NeedleEvent::kChannelInterface), 6);
  EXPECT_EQ(insertion.Count(NeedleEvent::kInterface), fresh);
  insertion.MoveTo(-2.0);
  EXPECT_EQ(insertion.Count(NeedleEvent::kWithdrawal), 1);
  const int out = insertion.Count(NeedleEvent::kChannelInterface);
  insertion.MoveTo(45.0);  // A new channel: everything is fresh again.
  EXPECT_EQ(insertion.Count(NeedleEvent::kContact), 2);
  EXPECT_EQ(insertion.Count(NeedleEvent::kInterface), 2 * fresh);
  EXPECT_EQ(insertion.Count(NeedleEvent::kChannelInterface), out);
}

TEST_F(NeedleForceTest, PlateauIsCuttingPlusFrictionOfTheBuriedTissues) {
  insertion.MoveTo(25.0);
  EXPECT_NEAR(insertion.last.cutting_n, 0.4, 1e-12);
  EXPECT_NEAR(insertion.last.friction_n, 0.03 * 2.0 + 0.01 * 23.0, 1e-3);
  EXPECT_NEAR(insertion.last.depth_mm, 25.0, 0.003);
  EXPECT_EQ(insertion.last.lateral_n, 0.0);
  EXPECT_NEAR(insertion.last.force_in_ct_n.z(), -insertion.last.AxialN(), 1e-12);
}

TEST_F(NeedleForceTest, CapsuleInsideTheBodyIsPressedAndPunctured) {
  insertion.MoveTo(29.9);
  const double before_n = insertion.last.AxialN();
  insertion.MoveTo(40.0);
  // The larger of cutting and polynomial at the tip; friction of 30 mm stays.
  EXPECT_NEAR(insertion.last.puncture_n + insertion.last.cutting_n, 0.48 + 0.52, 2e-3);
  EXPECT_NEAR(insertion.last.AxialN() - insertion.last.friction_n, 1.0, 2e-3);
  EXPECT_NEAR(before_n, 0.4 + 0.06 + 0.279, 2e-3);
  const double capsule_mm = PuncturePolynomial{0.048, 0.0052, 1.5}.PunctureDepthMm();
  insertion.MoveTo(30.0 + capsule_mm + 0.02);
  EXPECT_EQ(insertion.Count(NeedleEvent::kPuncture), 2);
  EXPECT_NEAR(insertion.last.cutting_n, 0.8, 1e-9);
  EXPECT_EQ(insertion.last.puncture_n, 0.0);
}

TEST_F(NeedleForceTest, WithdrawalIsFrictionAlone) {
  insertion.MoveTo(25.0);
  insertion.MoveTo(20.0);
  EXPECT_EQ(insertion.last.cutting_n, 0.0);
  EXPECT_NEAR(insertion.last.AxialN(), -(0.06 + 0.18), 1e-3);
  insertion.MoveTo(-1.0);
  EXPECT_EQ(insertion.last.AxialN(), 0.0);
  EXPECT_EQ(insertion.Count(NeedleEvent::kWithdrawal), 1);
  EXPECT_FALSE(insertion.state.in_body);
}

TEST_F(NeedleForceTest, TheCutChannelIsFreeAndItsEndCutsAgain) {
  insertion.MoveTo(28.0);
  insertion.MoveTo(24.0);
  insertion.MoveTo(27.5);
  EXPECT_EQ(insertion.last.cutting_n, 0.0);
  insertion.MoveTo(28.5);
  EXPECT_NEAR(insertion.last.cutting_n, 0.4, 1e-12);
  EXPECT_EQ(insertion.Count(NeedleEvent::kPuncture), 1);  // The skin is not met twice.
}

TEST_F(NeedleForceTest, StandingStillNeitherDriftsNorChatters) {
  insertion.MoveTo(25.0);
  const NeedleForce held = insertion.last;
  for (int i = 0; i < 20000; ++i) {
    insertion.StepTo(25.0);
    ASSERT_EQ(insertion.last.AxialN(), held.AxialN());
  }
}

// Work that the hand puts in over any closed loop within the body is not negative.
TEST_F(NeedleForceTest, NoClosedLoopGivesWork) {
  for (const double depth_mm : {1.0, 4.0, 15.0, 29.8, 35.0, 60.0}) {
    for (const double half_mm : {0.02, 0.3, 3.0, 12.0}) {
      Insertion drive{model, fat_and_liver};
      drive.MoveTo(depth_mm, 10.0);
      for (int loop = 0; loop < 4; ++loop) {
        drive.work_n_mm = 0.0;
        drive.MoveTo(depth_mm + half_mm, 10.0);
        drive.MoveTo(depth_mm - half_mm, 10.0);
        drive.MoveTo(depth_mm, 10.0);
        // -1e-5: the error of the trapezoid rule, f'' h^2 / 12 over 12 mm.
        EXPECT_GT(drive.work_n_mm, -1e-5) << depth_mm << " +- " << half_mm << ", loop " << loop;
      }
    }
  }
}

TEST_F(NeedleForceTest, InAndOutAgainTakesWork) {
  for (const double depth_mm : {2.0, 10.0, 45.0}) {
    Insertion drive{model, fat_and_liver};
    drive.MoveTo(depth_mm, 20.0);
    drive.MoveTo(-1.5, 20.0);
    EXPECT_GT(drive.work_n_mm, depth_mm > 4.0 ? 1.0 : -1e-9) << depth_mm;
    EXPECT_FALSE(drive.state.in_body);
  }
}

TEST_F(NeedleForceTest, BoneHoldsTheTipAndPushesBack) {
  Insertion drive{model, {{{0.0, kSkin}, {2.0, kFat}, {20.0, kBone}}}};
  drive.MoveTo(19.9);
  const double before_n = drive.last.AxialN();
  drive.MoveTo(20.5);
  EXPECT_EQ(drive.Count(NeedleEvent::kBoneContact), 1);
  EXPECT_NEAR(drive.last.bone_n, 10.0 * 0.5 + 0.01 * 5.0, 0.05);
  EXPECT_NEAR(drive.last.depth_mm, 20.0, 0.005);
  EXPECT_NEAR(drive.last.bone_penetration_mm, 0.5, 0.005);
  EXPECT_NEAR(drive.last.AxialN() - drive.last.bone_n, before_n, 0.01);
  drive.MoveTo(19.5);
  EXPECT_EQ(drive.last.bone_n, 0.0);
  EXPECT_EQ(drive.Count(NeedleEvent::kBoneRelease), 1);
}

TEST_F(NeedleForceTest, ADevicePushedThroughAThinBoneIsStillHeld) {
  Insertion drive{model, {{{0.0, kSkin}, {2.0, kFat}, {20.0, kBone}, {22.0, kFat}}}};
  drive.MoveTo(26.0);
  EXPECT_NEAR(drive.last.depth_mm, 20.0, 0.005);
  EXPECT_NEAR(drive.last.bone_n, 20.0, 1e-9);  // The bound.
  EXPECT_EQ(drive.Count(NeedleEvent::kBoneRelease), 0);
}

TEST_F(NeedleForceTest, SlidingOffABoneLetsGoWithoutAJump) {
  Insertion drive{model, {{{0.0, kSkin}, {2.0, kFat}, {20.0, kBone}}}};
  drive.MoveTo(21.5);
  drive.body = {{{0.0, kSkin}, {2.0, kFat}}};  // Beside the bone.
  double before_n = drive.last.bone_n;
  for (int i = 0; i < 3000 && drive.Count(NeedleEvent::kBoneRelease) == 0; ++i) {
    drive.aside_mm.x() += 0.005;
    drive.StepTo(21.5);
    EXPECT_LT(std::abs(drive.last.bone_n - before_n), 0.2);
    before_n = drive.last.bone_n;
  }
  EXPECT_EQ(drive.Count(NeedleEvent::kBoneRelease), 1);
  EXPECT_NEAR(drive.last.depth_mm, 21.5, 0.3);
}

TEST_F(NeedleForceTest, BoneContactDoesNotGiveEnergy) {
  Insertion drive{model, {{{0.0, kSkin}, {2.0, kFat}, {20.0, kBone}}}};
  drive.MoveTo(19.0);
  for (const double speed_mm_per_s : {1.0, 10.0, 100.0}) {
    for (int i = 0; i < 5; ++i) {
      drive.held_work_n_mm = 0.0;
      drive.MoveTo(20.8, speed_mm_per_s);
      drive.MoveTo(19.0, speed_mm_per_s);
      EXPECT_GT(drive.held_work_n_mm, 0.0) << speed_mm_per_s;
    }
  }
}

TEST_F(NeedleForceTest, AThinTissueLayerOfNoiseIsNotMet) {
  Insertion clean{model, {{{0.0, kSkin}, {2.0, kFat}}}};
  Insertion noisy{model,
                  {{{0.0, kSkin},
                    {2.0, kFat},
                    {12.0, kLiver},
                    {12.1, kFat},
                    {15.0, kBone},
                    {15.01, kFat},
                    {18.0, 0},
                    {18.15, kFat}}}};
  clean.MoveTo(25.0);
  noisy.MoveTo(25.0);
  EXPECT_EQ(noisy.Count(NeedleEvent::kPuncture), 1);
  EXPECT_EQ(noisy.Count(NeedleEvent::kWithdrawal), 0);
  EXPECT_NEAR(noisy.last.AxialN(), clean.last.AxialN(), 1e-6);
}

TEST_F(NeedleForceTest, FlickerAtAnInterfaceGivesOneEvent) {
  Insertion drive{model, fat_and_liver};
  drive.MoveTo(29.9);
  const int before = drive.Count(NeedleEvent::kInterface);
  for (int i = 0; i < 2000; ++i) {  // Tremor around the interface, going slowly deeper.
    const double z_mm = 29.95 + 0.00025 * i + 0.05 * std::sin(0.3 * i);
    drive.StepTo(z_mm);
  }
  EXPECT_EQ(drive.Count(NeedleEvent::kInterface) - before, 1);
  double roughness_n = 0.0;
  for (std::size_t i = drive.log.size() - 1990; i < drive.log.size(); ++i) {
    roughness_n =
        std::max(roughness_n, std::abs(drive.log[i].AxialN() - drive.log[i - 1].AxialN()));
  }
  EXPECT_LT(roughness_n, 0.05);  // 2 N/mm wall over 0.015 mm per step.
}

TEST_F(NeedleForceTest, VesselToLiverIsNotThroughTheCapsule) {
  Insertion drive{model,
                  {{{0.0, kSkin}, {2.0, kFat}, {20.0, kLiver}, {45.0, kVessel}, {50.0, kLiver}}}};
  drive.MoveTo(60.0);
  EXPECT_EQ(drive.Count(NeedleEvent::kPuncture), 2);  // Skin and capsule once each.
  EXPECT_NEAR(drive.last.cutting_n, 0.8, 1e-12);
}

// A beam of the free length in series with the tissue around the buried shaft.
TEST_F(NeedleForceTest, LateralForceIsBeamAndTissueInSeries) {
  insertion.MoveTo(30.0);
  insertion.aside_mm = {3.0, 0.0};
  insertion.StepTo(30.0);
  const double beam = Trocar().beam.EndStiffnessNPerMm(120.0);
  const double tissue = 0.02 * 30.0 / 3.0;  // Turning about the skin.
  EXPECT_NEAR(insertion.last.force_in_ct_n.x(), -3.0 * beam * tissue / (beam + tissue), 1e-3);
  EXPECT_NEAR(insertion.last.lateral_n, -insertion.last.force_in_ct_n.x(), 1e-12);
}

TEST_F(NeedleForceTest, TremorOnTheSkinIsOneContact) {
  for (int i = 0; i < 3000; ++i) insertion.StepTo(0.05 + 0.6 * std::sin(0.05 * i));
  EXPECT_EQ(insertion.Count(NeedleEvent::kContact), 1);
  EXPECT_EQ(insertion.Count(NeedleEvent::kWithdrawal), 0);
  insertion.MoveTo(-1.2);
  EXPECT_FALSE(insertion.state.in_body);
}

TEST_F(NeedleForceTest, LateralForceIsBoundedByTurningThePath) {
  insertion.MoveTo(60.0);
  for (int i = 0; i < 1000; ++i) {
    insertion.aside_mm.y() += 0.1;
    insertion.StepTo(60.0);
    ASSERT_LE(insertion.last.lateral_n, 3.0 + 1e-9);
  }
  EXPECT_GT(insertion.last.lateral_n, 2.9);
}

TEST_F(NeedleForceTest, DrawnBackNeedleTakesANewPath) {
  insertion.MoveTo(40.0);
  insertion.MoveTo(25.0);
  EXPECT_TRUE(insertion.state.redirecting);  // Fading.
  insertion.MoveTo(18.0);
  EXPECT_TRUE(insertion.state.redirecting);
  const double angle = 0.2;
  insertion.axis = {std::sin(angle), 0.0, std::cos(angle)};
  insertion.StepTo(18.0);
  EXPECT_NEAR(insertion.last.lateral_n, 0.0, 1e-9);
  for (double s_mm = 0.0; s_mm < 30.0; s_mm += 0.005) {  // Along the new axis.
    insertion.aside_mm.x() = s_mm * std::sin(angle);
    insertion.StepTo(18.0 + s_mm * std::cos(angle));
    ASSERT_LT(insertion.last.lateral_n, 0.05);
  }
  EXPECT_FALSE(insertion.state.redirecting);
  EXPECT_NEAR(insertion.state.path.direction_in_ct.x(), std::sin(angle), 1e-3);
  EXPECT_GT(insertion.last.cutting_n, 0.39);  // Fresh tissue on the new path.
}

TEST_F(NeedleForceTest, InvalidSamplesHoldThenFadeThenResume) {
  insertion.MoveTo(25.0);
  const double held_n = insertion.last.AxialN();
  NeedleInput lost{insertion.time_s, {NAN, NAN, NAN}, {NAN, 0, 0}, 0, false};
  lost.time_s = insertion.time_s + 0.09;
  EXPECT_EQ(model.Step(insertion.state, lost).AxialN(), held_n);
  lost.time_s = insertion.time_s + 0.2;
  EXPECT_NEAR(model.Step(insertion.state, lost).AxialN(), 0.5 * held_n, 1e-9);
  lost.time_s = insertion.time_s + 10.0;
  EXPECT_EQ(model.Step(insertion.state, lost).AxialN(), 0.0);
  insertion.time_s += 10.0;
  EXPECT_NEAR(insertion.StepTo(25.0).AxialN(), held_n, 1e-12);
}

TEST_F(NeedleForceTest, NotANumberGivesNoForceAndIsCounted) {
  insertion.MoveTo(25.0);
  NeedleForceState& state = insertion.state;
  const double nan = NAN;
  const NeedleInput bad[] = {
      {insertion.time_s + 0.001, {nan, 0, 25}, {0, 0, 1}, kFat, true},
      {insertion.time_s + 0.002, {0, 0, 25}, {0, nan, 1}, kFat, true},
      {insertion.time_s + 0.003, {0, 0, 25}, {0, 0, 0}, kFat, true},
      {insertion.time_s + 0.004, {0, 1e300, 25}, {0, 0, 1}, kFat, true},
      {nan, {0, 0, 25}, {0, 0, 1}, kFat, true},
  };
  for (const NeedleInput& input : bad)
    EXPECT_EQ(model.Step(state, input).force_in_ct_n.norm(), 0.0);
  EXPECT_EQ(state.num_rejected, 5);
  insertion.time_s += 0.005;
  EXPECT_GT(insertion.StepTo(25.0).AxialN(), 0.5);
}

TEST_F(NeedleForceTest, TimeThatDoesNotAdvanceChangesNothing) {
  insertion.MoveTo(25.0);
  const NeedleForceState before = insertion.state;
  for (const double back_s : {0.0, 0.5, 100.0}) {
    const NeedleForce force = model.Step(
        insertion.state, {insertion.time_s - back_s, {0, 0, 60.0}, {0, 0, 1}, kLiver, true});
    EXPECT_EQ(force.AxialN(), insertion.last.AxialN());
  }
  EXPECT_EQ(insertion.state.num_time_back, before.num_time_back + 3);
  EXPECT_EQ(insertion.state.depth_mm, before.depth_mm);
  EXPECT_EQ(insertion.state.time_s, before.time_s);
}

TEST_F(NeedleForceTest, StepSizeDoesNotMatter) {
  Insertion fine{model, fat_and_liver};
  Insertion coarse{model, fat_and_liver};
  fine.MoveTo(60.0, 5.0, 0.0001);
  coarse.MoveTo(60.0, 5.0, 0.01);
  EXPECT_NEAR(fine.last.AxialN(), coarse.last.AxialN(), 1e-3);
  fine.MoveTo(50.0, 5.0, 0.0001);
  coarse.MoveTo(50.0, 5.0, 0.01);
  EXPECT_NEAR(fine.last.AxialN(), coarse.last.AxialN(), 1e-3);
}

}  // namespace
}  // namespace acus::forces
