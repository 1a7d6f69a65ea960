#include "acus/physics/forces/models/mechanical_model.h"

#include <cmath>
#include <gtest/gtest.h>

#include "unit/patient/fitting/synthetic_recording.h"

namespace acus::fitting {
namespace {

TEST(MechanicalModel, SlidesAtItsReferenceSpeedWithItsResistance) {
  const DriveMotion drive;
  const MechanicalModel model = PlainTruth(drive);
  const forces::ForceCurve curve = Recording(model, drive, 0.0, 1);
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const double in_s = curve.time_s[i] - drive.rest_s;
    if (in_s > 4.0 && in_s < 11.9) {
      // The slow branch (12 s) is still building up its last percent.
      EXPECT_NEAR(curve.force_n[i], 0.05 + 0.3 + 0.016 * curve.depth_mm[i], 0.012);
    }
  }
  EXPECT_EQ(curve.force_n[0], 0.05);
}

TEST(MechanicalModel, RelaxesByItsTwoExponentials) {
  const DriveMotion drive;
  MechanicalModel model = PlainTruth(drive);
  model.offset_n = 0.0;
  MechanicalState state;
  for (int i = 0; i <= 12000; ++i) state.Advance(model, 1e-3 * i, 5e-3 * i);
  const auto strain = state.strain;
  for (const double held_s : {0.5, 2.0, 10.0, 40.0}) {
    MechanicalState held = state;
    const double sum = held.Advance(model, state.time_s + held_s, 60.0).in;
    const double expected = (0.3 * strain[0] + 0.5 * strain[1] * std::exp(-held_s / 0.8) +
                             0.2 * strain[2] * std::exp(-held_s / 12.0)) /
                            model.SteadyStrain(true);
    EXPECT_NEAR(sum, expected, 1e-12);
  }
}

TEST(MechanicalModel, TheSameMotionInOtherStepsGivesTheSameForce) {
  const DriveMotion drive;
  const MechanicalModel model = PlainTruth(drive);
  MechanicalState coarse;
  MechanicalState fine;
  coarse.Advance(model, 0.0, 0.0);
  fine.Advance(model, 0.0, 0.0);
  for (int i = 1; i <= 100; ++i) {
    const double a = coarse.Advance(model, 0.1 * i, 0.5 * i).Sum();
    double b = 0.0;
    for (int k = 0; k < 20; ++k) {
      const double t = 0.1 * (i - 1) + 0.005 * (k + 1);
      b = fine.Advance(model, t, 5.0 * t).Sum();
    }
    EXPECT_NEAR(a, b, 1e-3) << i;  // The play of 0.005 mm is all that differs.
  }
}

TEST(MechanicalModel, StartsAsASpringAndTurnsRound) {
  const DriveMotion drive;
  MechanicalModel model = PlainTruth(drive);
  model.relaxing_share = {0.0, 0.0};
  MechanicalState state;
  state.Advance(model, 0.0, 10.0);
  // dS/dx at 0 is 1 / build-up.
  EXPECT_NEAR(state.Advance(model, 1e-3, 10.0 + 0.005 + 0.009).in, 0.009 / 0.9, 1e-4);
  for (int i = 1; i < 2000; ++i) state.Advance(model, 1e-3 * (i + 1), 10.0 + 0.005 * i);
  EXPECT_NEAR(state.Advance(model, 3.0, 25.0).in, 1.0, 1e-6);
  EXPECT_NEAR(state.Advance(model, 4.0, 10.0).out, -1.0, 1e-4);
}

// A contact that is strained inwards lets go over the travel in which it was strained, then the
// other spring takes over: whatever the steps.
TEST(MechanicalModel, TurnsRoundExactlyWithinAStep) {
  MechanicalModel model = PlainTruth({});
  model.relaxing_share = {0.0, 0.0};
  MechanicalState state;
  state.Advance(model, 0.0, 0.0);
  state.Advance(model, 10.0, 50.0);  // s = 1.
  MechanicalState fine = state;
  const double back_mm = 2.0;
  for (int i = 1; i <= 20000; ++i) fine.Advance(model, 10.0 + 1e-4 * i, 50.0 - back_mm * i / 20000);
  const double at_once = state.Advance(model, 12.0, 50.0 - back_mm).Sum();
  EXPECT_NEAR(fine.strain[0], at_once, 1e-2);
  // ds/dx = -(1 + s) / b: s falls from 1 to 0 over b_in ln 2, then goes on with b_out.
  const double play_mm = 2.0 * 0.005;  // Taken up on the way in, and again on the way back.
  const double rest_mm = back_mm - play_mm - model.buildup_in_mm * std::log(2.0);
  EXPECT_NEAR(at_once, -(1.0 - std::exp(-rest_mm / model.buildup_out_mm)), 1e-9);
}

TEST(MechanicalModel, JitterOfAnEncoderIsNoMotion) {
  const DriveMotion drive;
  MechanicalModel model = PlainTruth(drive);
  model.relaxing_share = {0.0, 0.0};
  MechanicalState state;
  for (int i = 0; i < 2000; ++i) state.Advance(model, 1e-3 * i, 5e-3 * i);
  const double before = state.Advance(model, 2.0, 10.0).Sum();
  double after = before;
  for (int i = 1; i < 60000; ++i)
    after = state.Advance(model, 2.0 + 1e-3 * i, 10.0 - 0.002 * (i % 2)).Sum();
  EXPECT_NEAR(after, before, 1e-3);
}

TEST(MechanicalModel, SurvivesTimesThatDoNotAdvanceAndHugeLeaps) {
  const MechanicalModel model = PlainTruth({});
  MechanicalState state;
  state.Advance(model, 1.0, 0.0);
  const double before = state.Advance(model, 2.0, 5.0).Sum();
  EXPECT_EQ(state.Advance(model, 2.0, 50.0).Sum(), before);
  EXPECT_EQ(state.Advance(model, 1.0, 50.0).Sum(), before);
  EXPECT_TRUE(std::isfinite(state.Advance(model, 2.0 + 1e-12, 1e6).Sum()));
  EXPECT_TRUE(std::isfinite(state.Advance(model, 1e9, -1e6).Sum()));
}

TEST(MechanicalModel, APunctureIsMetOnceAndLeavesItsStep) {
  MechanicalModel model = PlainTruth({});
  model.punctures = {{.contact_mm = 10.0,
                      .puncture_mm = 4.0,
                      .a1_n_per_mm = 0.1,
                      .a2_n_per_mm2 = 0.05,
                      .recovery_mm = 0.5,
                      .step_n = 0.3}};
  const InternalPuncture& p = model.punctures[0];
  EXPECT_EQ(p.PeakN(), 0.1 * 4.0 + 0.05 * 16.0);
  EXPECT_EQ(p.ForceN(9.9), 0.0);
  EXPECT_NEAR(p.ForceN(12.0), 0.1 * 2.0 + 0.05 * 4.0, 1e-12);
  EXPECT_NEAR(p.ForceN(14.0), p.PeakN(), 1e-12);
  EXPECT_NEAR(p.ForceN(14.5), 0.3 + (p.PeakN() - 0.3) * std::exp(-1.0), 1e-12);
  const double plain = model.in.ForceN(13.0);
  EXPECT_NEAR(model.ResistanceInN(13.0, 13.0), plain + p.ForceN(13.0), 1e-12);
  EXPECT_NEAR(model.ResistanceInN(13.0, 30.0), plain + 0.3, 1e-12);  // Cut already.
  EXPECT_NEAR(model.ResistanceInN(12.0, 13.0), model.in.ForceN(12.0) + p.ForceN(12.0), 1e-12);
}

TEST(MechanicalModel, ProfilesAndReleasesAreWhatTheySay) {
  const ResistanceProfile profile{{0.0, 10.0, 20.0}, {1.0, 2.0, 0.5}};
  EXPECT_EQ(profile.ForceN(5.0), 1.5);
  EXPECT_EQ(profile.ForceN(-5.0), 0.5);   // The first interval goes on.
  EXPECT_EQ(profile.ForceN(100.0), 0.0);  // Never below 0.
  const Release release{30.0, 0.5, 0.4};
  EXPECT_NEAR(release.ForceN(40.0), 0.4, 1e-6);
  EXPECT_EQ(release.ForceN(30.0), 0.2);
  EXPECT_NEAR(release.ForceN(20.0), 0.0, 1e-6);
  MechanicalModel model = PlainTruth({});
  model.surface_mm = 5.0;
  EXPECT_EQ(model.ResistanceInN(4.0, 4.0), 0.0);
  EXPECT_EQ(model.ResistanceOutN(5.0), 0.0);
  EXPECT_GT(model.ResistanceOutN(5.1), 0.0);
}

}  // namespace
}  // namespace acus::fitting
