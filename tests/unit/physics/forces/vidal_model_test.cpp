#include "acus/physics/forces/models/vidal_model.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "support/force_scenes.h"

namespace acus::forces {
namespace {

using Eigen::Vector3d;
using testing_support::DrivenVidal;
using testing_support::LayeredBodyField;
using testing_support::ShippedTable;
using testing_support::Trocar18G;

/// Along z through a body of even tissue, so that the resistance is one number.
class VidalTest : public testing::Test {
 protected:
  VidalTest() : table(ShippedTable("vidal.json")) { Make(); }

  void Make() {
    model.emplace(table, Trocar18G(), body);
    driven.emplace(DrivenVidal{*model, body});
    place_mm = {0, 0, -3};
    events.clear();
  }
  const NeedleForce& MoveTo(double z_mm, double speed_mm_per_s = 8.0, double dt_s = 0.001) {
    const double from_mm = place_mm.z();
    const int steps =
        static_cast<int>(std::ceil(std::abs(z_mm - from_mm) / (speed_mm_per_s * dt_s) - 1e-9));
    for (int i = 1; i <= steps; ++i) {
      place_mm.z() = from_mm + (z_mm - from_mm) * i / steps;
      StepHere(dt_s);
    }
    return driven->last;
  }
  const NeedleForce& StepHere(double dt_s = 0.001) {
    time_s += dt_s;
    driven->Step(time_s, place_mm);
    if (driven->last.event != NeedleEvent::kNone) events.push_back(driven->last.event);
    return driven->last;
  }
  int Count(NeedleEvent event) const {
    return static_cast<int>(std::count(events.begin(), events.end(), event));
  }
  double ResistanceAt(double hu) const { return table.vidal.resistance_n_s_per_mm(hu); }

  ForceTable table;
  LayeredBodyField body{{{0.0, "muscle", 50}, {60.0, "bone", 900}}};
  std::optional<VidalModel> model;
  std::optional<DrivenVidal> driven;
  Vector3d place_mm{0, 0, -3};
  double time_s = 0.0;
  std::vector<NeedleEvent> events;
};

// Before the puncture a spring to the skin; the skin is where the CT passes -300 HU, at z = 0.33.
TEST_F(VidalTest, TheSkinIsASpringUntilItsThreshold) {
  const double skin_mm = -1.0 + 2.0 * 700.0 / 1050.0;
  MoveTo(3.0);
  EXPECT_NEAR(driven->last.puncture_n, 0.4 * (3.0 - skin_mm), 1e-3);
  EXPECT_NEAR(driven->last.force_in_ct_n.z(), -0.4 * (3.0 - skin_mm), 1e-3);
  EXPECT_EQ(Count(NeedleEvent::kContact), 1);
  MoveTo(skin_mm + 2.0 / 0.4 - 0.01);
  EXPECT_FALSE(driven->state.pierced);
  MoveTo(skin_mm + 2.0 / 0.4 + 0.01);
  EXPECT_TRUE(driven->state.pierced);
  EXPECT_EQ(Count(NeedleEvent::kPuncture), 1);
  EXPECT_NEAR(driven->last.depth_mm, 5.0, 0.02);
}

TEST_F(VidalTest, InANickTheSkinGivesWayAtOnce) {
  table.nick = {Vector3d::Zero(), 2.0};
  Make();
  MoveTo(1.0);
  EXPECT_TRUE(driven->state.pierced);
  EXPECT_EQ(Count(NeedleEvent::kPuncture), 1);
  EXPECT_LT(driven->last.puncture_n, 1e-9);
}

TEST_F(VidalTest, ATipDraggedOverTheSkinFeelsFriction) {
  MoveTo(2.0);
  const double pressed_n = driven->last.puncture_n;
  for (int i = 0; i < 2000; ++i) {
    place_mm.x() += 0.005;
    StepHere();
  }
  EXPECT_NEAR(driven->last.puncture_n, pressed_n, 1e-3);
  EXPECT_NEAR(driven->last.force_in_ct_n.x(), -0.3 * pressed_n, 2e-3);
  EXPECT_FALSE(driven->state.pierced);
  MoveTo(0.2);
  StepHere();
  EXPECT_EQ(driven->last.force_in_ct_n.norm(), 0.0);
}

// Eq. 2 to 5: force per speed from the table, at any speed and any rate.
TEST_F(VidalTest, ResistanceIsProportionalToSpeed) {
  for (const double speed : {2.0, 8.333, 20.0}) {
    for (const double rate_hz : {500.0, 1000.0, 4000.0}) {
      Make();
      MoveTo(10.0, speed, 1.0 / rate_hz);
      MoveTo(50.0, speed, 1.0 / rate_hz);
      EXPECT_NEAR(driven->last.cutting_n, ResistanceAt(50.0) * speed, 1e-3 * speed) << rate_hz;
    }
  }
}

TEST_F(VidalTest, StandingStillTheForceFades) {
  MoveTo(30.0);
  EXPECT_GT(driven->last.AxialN(), 0.5);
  for (int i = 0; i < 3000; ++i) StepHere();
  EXPECT_NEAR(driven->last.AxialN(), 0.0, 1e-9);
}

TEST_F(VidalTest, WithdrawalHasAResistanceOfItsOwn) {
  MoveTo(40.0);
  MoveTo(20.0, 12.0);
  EXPECT_NEAR(driven->last.friction_n, -table.vidal.withdrawal_n_s_per_mm * 12.0, 1e-3);
  EXPECT_EQ(driven->last.cutting_n, 0.0);
  MoveTo(-3.0, 12.0);
  EXPECT_EQ(driven->last.force_in_ct_n.norm(), 0.0);
  EXPECT_EQ(Count(NeedleEvent::kWithdrawal), 1);
}

// Eq. 6: where the gradient is above the threshold, K_edge times as much.
TEST_F(VidalTest, InterfacesResistMore) {
  body = LayeredBodyField({{0.0, "fat", -100}, {30.0, "muscle", 50}});
  table.vidal.largest_n_per_mm = 1e3;  // No delay worth speaking of, to see the factor.
  table.vidal.averaging_s = 0.0;
  Make();
  MoveTo(28.0);
  EXPECT_NEAR(driven->last.cutting_n, ResistanceAt(-100.0) * 8.0, 1e-4);
  const int before = Count(NeedleEvent::kInterface);
  MoveTo(30.0);
  EXPECT_NEAR(driven->last.cutting_n, 1.5 * ResistanceAt(body.HuAt(place_mm)) * 8.0, 1e-2);
  MoveTo(33.0);
  EXPECT_NEAR(driven->last.cutting_n, ResistanceAt(50.0) * 8.0, 1e-3);
  EXPECT_EQ(Count(NeedleEvent::kInterface) - before, 1);
}

// Eq. 3 as printed: the sum from t - m to t, which are m + 1 sub-forces, over m.
TEST_F(VidalTest, ThePrintedMeanIsThatOfTheLastSteps) {
  table.vidal.passive_average = false;
  table.vidal.averaging_s = 0.010;
  Make();
  MoveTo(30.0);
  const double steady_n = ResistanceAt(50.0) * 8.0;
  EXPECT_NEAR(driven->last.cutting_n, 1.1 * steady_n, 1e-9);
  for (int i = 1; i <= 4; ++i) StepHere();  // Standing still.
  EXPECT_NEAR(driven->last.cutting_n, 0.7 * steady_n, 1e-9);
  for (int i = 1; i <= 6; ++i) StepHere();
  EXPECT_NEAR(driven->last.cutting_n, 0.1 * steady_n, 1e-9);
  StepHere();
  EXPECT_NEAR(driven->last.cutting_n, 0.0, 1e-9);
}

// The passive mean: a spring of at most largest_n_per_mm in series with the resistance.
TEST_F(VidalTest, ThePassiveMeanIsNeverStifferThanItsBound) {
  MoveTo(30.0);
  for (int i = 0; i < 3000; ++i) StepHere();
  double before_n = driven->last.AxialN();
  for (int i = 0; i < 50; ++i) {
    place_mm.z() += 0.2;  // 200 mm/s.
    StepHere();
    ASSERT_LE(driven->last.AxialN() - before_n, 0.2 * 1.0 + 1e-9);
    before_n = driven->last.AxialN();
  }
}

// Eq. 8 with K2: nothing for small distances, K3 times the mean distance for larger ones.
TEST_F(VidalTest, GuidanceIsClampedToZeroNearTheLine) {
  MoveTo(35.0);
  for (const double aside_mm : {0.01, 0.2, 3.0}) {
    place_mm.x() = aside_mm;
    for (int i = 0; i < 3000; ++i) StepHere();
    const double wanted_n = 0.2 * aside_mm;
    const double k2 = 1.0 - std::exp(-0.5 * wanted_n * wanted_n / (0.05 * 0.05));
    EXPECT_NEAR(driven->last.force_in_ct_n.x(), -k2 * wanted_n, 1e-6) << aside_mm;
    EXPECT_NEAR(driven->last.lateral_n, k2 * wanted_n, 1e-6);
  }
}

// Eq. 8 as printed: the sum from t - n to t, which are n + 1 terms, over n; no damping, no limit.
TEST_F(VidalTest, ThePrintedGuidanceIsASumOfTheLastSteps) {
  table.vidal.passive_average = false;
  table.vidal.averaging_s = 0.0;
  table.vidal.guidance_averaging_s = 0.010;
  table.settings.lateral_limit_n = 0.1;
  table.vidal.resistance_n_s_per_mm = CubicBSpline({0, 100}, {0, 0, 0, 0}, "none");
  for (const int steps : {1, 4, 11}) {
    Make();
    MoveTo(35.0);
    for (int i = 0; i < 20; ++i) StepHere();
    place_mm.x() = 3.0;
    for (int i = 0; i < steps; ++i) StepHere();
    const double constraint_n = 0.2 / 10 * steps * 3.0;
    const double k2 = 1.0 - std::exp(-0.5 * constraint_n * constraint_n / (0.05 * 0.05));
    EXPECT_NEAR(driven->last.lateral_n, k2 * constraint_n, 1e-9) << steps;
  }
}

TEST_F(VidalTest, OrientationIsLockedBelowTwoCentimetres) {
  MoveTo(15.0);
  const Vector3d entry = driven->state.path.entry_in_ct_mm;
  driven->axis = Vector3d(0.3, 0.0, 1.0).normalized();
  // Near the skin it turns about its entry, with the tip, without a force.
  for (int i = 0; i < 2000; ++i) {
    place_mm.x() = 0.3 * (i + 1) / 2000.0 * (place_mm.z() - entry.z());
    StepHere();
  }
  for (int i = 0; i < 3000; ++i) StepHere();
  EXPECT_LT(driven->last.lateral_n, 1e-3);
  EXPECT_GT(driven->state.path.direction_in_ct.x(), 0.28);
  // Deeper, the axis does not matter any more.
  while (place_mm.z() < 35.0) {
    place_mm += 0.008 * driven->state.path.direction_in_ct;
    StepHere();
  }
  const Vector3d locked = driven->state.path.direction_in_ct;
  driven->axis = Vector3d(-0.3, 0.0, 1.0).normalized();
  for (int i = 0; i < 500; ++i) {
    place_mm.x() -= 0.004;
    StepHere();
  }
  EXPECT_EQ(driven->state.path.direction_in_ct, locked);
  EXPECT_GT(driven->last.lateral_n, 0.3);
}

TEST_F(VidalTest, BoneHoldsTheTipByAProxy) {
  MoveTo(58.0);
  MoveTo(61.5);
  EXPECT_EQ(Count(NeedleEvent::kBoneContact), 1);
  const double beyond_mm =
      place_mm.z() - driven->state.bone_mm - driven->state.path.entry_in_ct_mm.z();
  EXPECT_NEAR(driven->last.bone_penetration_mm, beyond_mm, 1e-9);
  EXPECT_NEAR(driven->last.bone_n, 2.0 * beyond_mm + 0.004 * 8.0, 1e-3);
  EXPECT_GT(driven->last.bone_n, 2.0);
  MoveTo(57.0);
  EXPECT_EQ(Count(NeedleEvent::kBoneRelease), 1);
  EXPECT_EQ(driven->last.bone_n, 0.0);
}

// Eq. 7 in eq. 3 as printed: the sum of the last steps' K_bone times the way to the proxy, over m,
// without damping.
TEST_F(VidalTest, ThePrintedMeanHoldsTheForceOfBone) {
  table.vidal.passive_average = false;
  table.vidal.averaging_s = 0.010;
  table.settings.bone.damping_n_s_per_mm = 0.0;
  Make();
  MoveTo(58.0);
  MoveTo(61.5);
  const double beyond_mm = driven->last.bone_penetration_mm;
  EXPECT_GT(beyond_mm, 0.5);
  double sum_n = 0.0;  // At 8 mm/s each of the 11 steps was 0.008 mm less deep than the next.
  for (int i = 0; i <= 10; ++i) sum_n += 2.0 * (beyond_mm - 0.008 * i);
  EXPECT_NEAR(driven->last.bone_n, sum_n / 10, 1e-3);
  EXPECT_NEAR(driven->last.AxialN(), driven->last.bone_n, 1e-9);
}

TEST_F(VidalTest, GravityIsAConstantForce) {
  table.vidal.gravity_in_ct_n = {0.0, 0.3, 0.0};
  Make();
  StepHere();
  EXPECT_EQ(driven->last.force_in_ct_n, Vector3d(0.0, 0.3, 0.0));
  MoveTo(30.0);
  EXPECT_NEAR(driven->last.force_in_ct_n.y(), 0.3, 1e-9);
}

TEST_F(VidalTest, LostAndBadSamplesAreThoseOfTheLayeredModel) {
  MoveTo(30.0);
  const double held_n = driven->last.AxialN();
  NeedleInput lost{time_s + 0.09, {NAN, NAN, NAN}, {NAN, 0, 0}, 0, false};
  EXPECT_EQ(model->Step(driven->state, lost).AxialN(), held_n);
  lost.time_s = time_s + 0.2;
  EXPECT_NEAR(model->Step(driven->state, lost).AxialN(), 0.5 * held_n, 1e-9);
  const NeedleInput bad{time_s + 0.3, {NAN, 0, 25}, {0, 0, 1}, 3, true};
  EXPECT_EQ(model->Step(driven->state, bad).force_in_ct_n.norm(), 0.0);
  EXPECT_EQ(driven->state.num_rejected, 1);
}

TEST(VidalSettings, RefuseWhatCannotBe) {
  const auto table = [](const char* block) {
    return ForceTableFromJson(
        nlohmann::json::parse(std::string(R"({"format": "acus-forces/1", "tissues":
          [{"tissue": "soft_tissue", "source": "test"}], )") +
                              block + "}"),
        "table.json");
  };
  const auto message = [&](const char* block) -> std::string {
    try {
      table(block);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  using testing::HasSubstr;
  EXPECT_EQ(message(R"("description": "nothing wrong")"), "");
  EXPECT_THAT(message(R"("vidal": {"edge_factor": 0.5})"), HasSubstr("edge_factor"));
  EXPECT_THAT(message(R"("vidal": {"resistance": {"hu": [0, 1], "n_s_per_mm": [1, 1, 1, -1]}})"),
              HasSubstr("n_s_per_mm"));
  EXPECT_THAT(message(R"("vidal": {"resistance": {"hu": [0, 1, 2], "n_s_per_mm": [1, 1, 1, 1]}})"),
              HasSubstr("need 5 coefficients"));
  EXPECT_THAT(message(R"("vidal": {"bone_hu": -400})"), HasSubstr("bone_hu"));
  EXPECT_THAT(message(R"("alamilla": {"lugre": {"sigma0_per_mm": 0}})"), HasSubstr("sigma0"));
  EXPECT_THAT(message(R"("alamilla": {"lugre": {"sigma0": 1}})"), HasSubstr("sigma0_per_mm"));
  EXPECT_THAT(message(R"("alamilla": {"hard_contact": {"duration_ms": 0}})"),
              HasSubstr("duration_ms"));
  EXPECT_THAT(
      message(
          R"("hu_tissues": [{"tissue": "fat", "from_hu": 0}, {"tissue": "bone", "from_hu": -1}])"),
      HasSubstr("/hu_tissues/1/from_hu"));
  EXPECT_THAT(message(R"("hu_tissues": [{"tissue": "muscel", "from_hu": 0}])"),
              HasSubstr("muscle"));
}

}  // namespace
}  // namespace acus::forces
