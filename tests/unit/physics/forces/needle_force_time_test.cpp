// The layered law with tissues that relax and hold the shaft by rate and rest.
#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/random.h"
#include "layered_body.h"
#include "support/wild_hand.h"

namespace acus::forces {
namespace {

using testing_support::SameBits;
using testing_support::WildHand;

/// SimpleTable with one Prony series for all, 0.3 with 0.5 s and 0.2 with 6 s, and more if asked.
ForceTable RelaxingTable(double rate = 0.0, double dwell = 0.0) {
  return ForceTableFromJson(
      nlohmann::json::parse(Message(R"({"format": "acus-forces/1", "tissues": [
    {"tissue": "soft_tissue", "source": "test", "a1_n_per_mm": 0.1, "a2_n_per_mm2": 0.05,
     "puncture_n": 2.1, "cutting_n": 0.6, "friction_n_per_mm": 0.02,
     "relaxation": [{"share": 0.3, "time_s": 0.5}, {"share": 0.2, "time_s": 6}],
     "friction_rate": )",
                                    rate, R"(, "friction_dwell": )", dwell, "}]}")),
      "relaxing");
}

const volume::Label kSoft = volume::LabelOf("soft_tissue");

TEST(NeedleForceTime, AMembraneRelaxesAsItsPronySeriesSays) {
  const NeedleForceModel model(RelaxingTable(), Trocar());
  Insertion drive{model, {{{0.0, kSoft}}}};
  drive.StepTo(0.0);  // Its first sample: the skin is touched here.
  drive.MoveTo(3.0, 5.0);
  const PuncturePolynomial law{0.1, 0.05, 2.1};
  const auto expected = [&](double held_s) {
    const auto y = [&](double tau) {
      return 5.0 * tau * (1.0 - std::exp(-0.6 / tau)) * std::exp(-held_s / tau);
    };
    return 0.5 * law.ForceN(3.0) + 0.3 * law.ForceN(y(0.5)) + 0.2 * law.ForceN(y(6.0));
  };
  EXPECT_NEAR(drive.last.puncture_n, expected(0.0), 1e-9);
  for (int i = 0; i < 2000; ++i) drive.StepTo(3.0);
  EXPECT_NEAR(drive.last.puncture_n, expected(2.0), 1e-9);
  drive.StepTo(3.0, 3600.0);
  EXPECT_NEAR(drive.last.puncture_n, 0.5 * law.ForceN(3.0), 1e-9);
}

TEST(NeedleForceTime, WhatHoldsAWithdrawnTipRelaxesWithTheShaft) {
  ForceTable table = RelaxingTable();
  const NeedleForceModel without(table, Trocar());
  table.tissue[kSoft].withdrawal_tip_n = 0.3;
  const NeedleForceModel with(table, Trocar());
  Insertion a{without, {{{0.0, kSoft}}}};
  Insertion b{with, {{{0.0, kSoft}}}};
  for (Insertion* drive : {&a, &b}) {
    drive->MoveTo(40.0, 5.0);
    drive->MoveTo(25.0, 5.0);
  }
  EXPECT_NEAR(a.last.friction_n, -0.5, 0.01);
  EXPECT_NEAR(b.last.friction_n, a.last.friction_n - 0.3, 0.01);
  const double ratio = b.last.friction_n / a.last.friction_n;
  for (Insertion* drive : {&a, &b}) drive->StepTo(25.0, 3600.0);
  EXPECT_LT(std::abs(b.last.friction_n), 0.5);  // Half of it relaxes.
  EXPECT_NEAR(b.last.friction_n / a.last.friction_n, ratio, 1e-9);
}

TEST(NeedleForceTime, ASlowNeedlePuncturesDeeperButPunctures) {
  const NeedleForceModel model(RelaxingTable(), Trocar());
  const PuncturePolynomial elastic{0.1, 0.05, 2.1};
  const PuncturePolynomial relaxed{0.05, 0.025, 2.1};
  double before_mm = elastic.PunctureDepthMm() - 1e-9;
  for (const double speed_mm_per_s : {1000.0, 50.0, 5.0, 0.5, 0.02}) {
    Insertion drive{model, {{{0.0, kSoft}}}, {}, 0.0, 0.0};
    drive.StepTo(0.0);
    const double dt_s = 0.005 / speed_mm_per_s;
    while (!drive.state.pierced && drive.z_mm < 30.0) drive.StepTo(drive.z_mm + 0.005, dt_s);
    EXPECT_GE(drive.z_mm, before_mm) << speed_mm_per_s;
    EXPECT_LE(drive.z_mm, relaxed.PunctureDepthMm() + 0.006) << speed_mm_per_s;
    before_mm = drive.z_mm;
  }
  EXPECT_NEAR(before_mm, relaxed.PunctureDepthMm(), 0.05);
}

TEST(NeedleForceTime, CuttingRelaxesInAHoldAndRecovers) {
  const NeedleForceModel model(RelaxingTable(), Trocar());
  Insertion drive{model, {{{0.0, kSoft}}}};
  drive.MoveTo(40.0, 5.0);
  EXPECT_NEAR(drive.last.cutting_n, 0.6, 1e-9);
  EXPECT_NEAR(drive.last.friction_n, 0.02 * drive.last.depth_mm, 1e-9);
  for (int i = 0; i < 3000; ++i) drive.StepTo(40.0);
  const double left = 0.5 + 0.3 * std::exp(-6.0) + 0.2 * std::exp(-0.5);
  EXPECT_NEAR(drive.last.cutting_n, 0.6 * left, 1e-9);
  drive.MoveTo(42.0, 5.0);
  EXPECT_NEAR(drive.last.cutting_n, 0.6, 1e-9);
  // Off and on again at once: what has crept is still ahead of the tip; later it is back.
  for (int i = 0; i < 3000; ++i) drive.StepTo(42.0);
  Insertion later = drive;
  drive.MoveTo(41.0, 50.0);
  drive.MoveTo(42.0, 50.0);
  later.MoveTo(41.0, 50.0);
  for (int i = 0; i < 60'000; ++i) later.StepTo(41.0);
  later.MoveTo(42.0, 50.0);
  EXPECT_LT(drive.last.cutting_n, 0.6 * 0.75);
  EXPECT_NEAR(later.last.cutting_n, 0.6, 0.01);
  drive.MoveTo(35.0, 50.0);
  EXPECT_EQ(drive.last.cutting_n, 0.0);
}

// The way through the shipped table, in, held, out: the same force however it is sampled.
TEST(NeedleForceTime, TheForceDoesNotDependOnTheSamples) {
  const NeedleForceModel model(ReadForceTable(kConfigs / "forces" / "viscoelastic.json"), Trocar());
  const LayeredBody body{{{0.0, volume::LabelOf("skin")},
                          {2.0, volume::LabelOf("fat")},
                          {15.0, volume::LabelOf("muscle")},
                          {30.0, volume::LabelOf("liver")}}};
  std::vector<std::vector<double>> forces;
  for (const double dt_s : {0.0001, 0.001, 0.01}) {
    Insertion drive{model, body};
    std::vector<double>& force = forces.emplace_back();
    for (const double to_mm : {4.0, 12.0, 25.0, 60.0, 57.0, 60.5, 20.0}) {
      drive.MoveTo(to_mm, 10.0, dt_s);
      force.push_back(drive.last.AxialN());
      for (int i = 0; i < 200; ++i) drive.StepTo(to_mm, 0.01);
      force.push_back(drive.last.AxialN());
    }
  }
  for (std::size_t i = 0; i < forces[0].size(); ++i) {
    EXPECT_NEAR(forces[1][i], forces[0][i], 0.01) << i;
    EXPECT_NEAR(forces[2][i], forces[0][i], 0.06) << i;  // An interface is met half way: 0.05 mm.
  }
}

TEST(NeedleForceTime, NoClosedLoopWithRestsGivesWork) {
  const NeedleForceModel model(RelaxingTable(0.1, 0.1), Trocar());
  for (const double depth_mm : {3.0, 15.0, 60.0}) {
    for (const double half_mm : {0.02, 0.3, 3.0}) {
      for (const double rest_s : {0.0, 0.3, 20.0}) {
        Insertion drive{model, {{{0.0, kSoft}}}};
        drive.MoveTo(depth_mm, 10.0);
        // Springs that were strained on the way in give that back, once: at most 1/2 z0 F along the
        // shaft and F^2 / 2 K at the tip. -1e-5: the error of the trapezoid rule.
        const double stored_mj = 0.25 * 1.5 * 0.02 * depth_mm + 0.25 * 0.6 * 0.6;
        drive.work_n_mm = 0.0;
        for (int loop = 0; loop < 60; ++loop) {
          const double before_mj = drive.work_n_mm;
          for (const double to_mm : {depth_mm + half_mm, depth_mm - half_mm, depth_mm}) {
            drive.MoveTo(to_mm, 10.0);
            if (rest_s > 0.0) drive.StepTo(to_mm, rest_s);
          }
          EXPECT_GT(drive.work_n_mm, -stored_mj - 1e-5);
          if (loop < 50) continue;
          EXPECT_GT(drive.work_n_mm, before_mj - 1e-5)
              << depth_mm << " +- " << half_mm << ", rest " << rest_s << ", loop " << loop;
        }
      }
    }
  }
}

TEST(NeedleForceTime, ATimeOfAnotherTissueChangesNothing) {
  nlohmann::json rows = nlohmann::json::parse(R"([
      {"tissue": "soft_tissue", "source": "test", "cutting_n": 0.5, "friction_n_per_mm": 0.02},
      {"tissue": "skin", "source": "test", "a1_n_per_mm": 0.1, "puncture_n": 1, "cutting_n": 1,
       "friction_n_per_mm": 0.03, "withdrawal_friction_n_per_mm": 0.02},
      {"tissue": "liver", "source": "test"}])");
  nlohmann::json document = {{"format", "acus-forces/1"}, {"tissues", rows}};
  const NeedleForceModel without(ForceTableFromJson(document, "without"), Trocar());
  document["tissues"][2]["friction_rate"] = 0.1;
  const NeedleForceModel with(ForceTableFromJson(document, "with"), Trocar());
  ASSERT_TRUE(with.table().HasTime() && !without.table().HasTime());
  const LayeredBody body{{{0.0, volume::LabelOf("skin")}, {12.0, kSoft}}};
  Insertion a{without, body};
  Insertion b{with, body};
  for (const double to_mm : {5.0, 25.0, 17.0, 26.0, 3.0, 30.0}) {
    for (Insertion* drive : {&a, &b}) {
      drive->MoveTo(to_mm, 20.0);
      drive->StepTo(to_mm, 2.0);
    }
    EXPECT_NEAR(b.last.AxialN(), a.last.AxialN(), 1e-6) << to_mm;  // They have turned round.
  }
}

TEST(NeedleForceTime, AMillionRandomStepsStayFiniteAndBounded) {
  const NeedleForceModel model(ReadForceTable(kConfigs / "forces" / "viscoelastic.json"), Trocar());
  const double bound_n = model.table().settings.largest_force_n;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    WildHand hand(seed);
    WildHand again(seed);
    NeedleForceState state;
    NeedleForceState copy;
    for (int i = 0; i < 100'000; ++i) {
      const NeedleForce out = model.Step(state, hand.Next());
      ASSERT_TRUE(out.force_in_ct_n.allFinite()) << seed << " " << i;
      ASSERT_LE(out.force_in_ct_n.norm(), bound_n * (1.0 + 1e-12)) << seed << " " << i;
      ASSERT_GE(out.puncture_n, 0.0);
      ASSERT_GE(out.cutting_n, 0.0);
      if (i >= 10'000) continue;
      ASSERT_TRUE(SameBits(out, model.Step(copy, again.Next())));
    }
  }
}

}  // namespace
}  // namespace acus::forces
