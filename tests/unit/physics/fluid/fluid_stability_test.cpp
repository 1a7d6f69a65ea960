// Hard cases: energy at the plunger, bounds and accounts under random hands.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <vector>

#include "acus/base/core/random.h"
#include "acus/physics/fluid/fluid_model.h"
#include "injections.h"
#include "support/allocation_counter.h"

namespace acus::fluid {
namespace {

using namespace testing_support;

struct HardCase {
  std::string name;
  double compliance_ml_per_kpa = 0.0;
  double friction_n = 0.0;
  double air_share = 0.0;
  double coupling_n_per_mm = 5.0;
  double dt_s = 1e-3;
  bool is_blocked = false;
};

std::vector<HardCase> HardCases() {
  std::vector<HardCase> out;
  for (const double dt_s : {1.0 / 4000.0, 1.0 / 250.0}) {
    for (const double coupling : {1.0, 1e3, 1e5}) {
      for (const double air : {0.0, 0.05, 1.0}) {
        for (const double compliance : {0.0, 3e-4}) {
          for (const bool is_blocked : {false, true}) {
            HardCase c{"",   compliance, compliance > 0.0 ? 2.0 : 0.0, air, coupling,
                       dt_s, is_blocked};
            c.name = "dt " + std::to_string(dt_s) + " coupling " + std::to_string(coupling) +
                     " air " + std::to_string(air) + " compliance " + std::to_string(compliance) +
                     (is_blocked ? " blocked" : "");
            out.push_back(c);
          }
        }
      }
    }
  }
  return out;
}

FluidModel ModelOf(const HardCase& c) {
  Syringe syringe = IdealSyringe();
  syringe.compliance_ml_per_kpa = c.compliance_ml_per_kpa;
  syringe.static_friction_n = c.friction_n;
  syringe.sliding_friction_n = 0.5 * c.friction_n;
  return FluidModel(TestTable(), syringe, {5.0, c.air_share}, Tuohy16G());
}

/// A hand that trembles, taps and pulls, within the stroke.
class RandomHand {
 public:
  RandomHand(double start_mm, std::uint64_t index)
      : hand_mm_(start_mm), random_(4, "hand", index) {}

  void Move(FluidInput& input, double dt_s) {
    if (random_.Uniform() < 2.0 * dt_s) aim_mm_ = random_.Uniform(-20.0, 20.0);
    const double before_mm = hand_mm_;
    hand_mm_ += (aim_mm_ + 30.0 - hand_mm_) * std::min(1.0, 8.0 * dt_s) + 0.05 * random_.Normal();
    hand_mm_ = std::clamp(hand_mm_, 0.0, 56.0);
    input.hand_mm = hand_mm_;
    input.hand_mm_per_s = (hand_mm_ - before_mm) / dt_s;
  }
  RandomStream& random() { return random_; }

 private:
  double hand_mm_;
  double aim_mm_ = 0.0;
  RandomStream random_;
};

struct Worst {
  double energy_mj = 0.0;
  double kpa = 0.0;
  double force_n = 0.0;
  double liquid_ml = 0.0;
  double air_ml = 0.0;
  int iterations = 0;
};

/// The hand's work never falls below what it put in: the least sum of force times travel.
Worst PlayRandomly(const HardCase& c, std::uint64_t index, int num_steps) {
  const FluidModel model = ModelOf(c);
  FluidState state = model.NewState();
  const double liquid_ml = TotalLiquidMl(state);
  const double air_ml = TotalAirMl(state);
  RandomHand hand(state.plunger_mm, index);
  FluidInput input = Held(kBlocked, state.plunger_mm, c.coupling_n_per_mm);
  double work_mj = 0.0;
  double before_mm = state.plunger_mm;
  Worst worst;
  for (int n = 0; n < num_steps; ++n) {
    hand.Move(input, c.dt_s);
    if (!c.is_blocked && hand.random().Uniform() < 5.0 * c.dt_s) {
      const int tissues[] = {kBlocked, kSpace, kPorous, kOpenTissue};
      input.bevel[0].tissue = tissues[hand.random().Next() % 4];
      input.bevel[1].tissue = tissues[hand.random().Next() % 4];
      input.bevel[1].share = hand.random().Uniform() < 0.5 ? 0.0 : hand.random().Uniform();
      input.bevel[0].share = 1.0 - input.bevel[1].share;
      if (input.bevel[0].tissue == input.bevel[1].tissue) input.bevel[1].share = 0.0;
    }
    input.tip_mm.z() += 0.01 * hand.random().Normal();
    const FluidOutput output = model.Step(state, input, c.dt_s);
    work_mj += output.reaction_n * (input.hand_mm - before_mm);
    before_mm = input.hand_mm;
    worst.energy_mj = std::min(worst.energy_mj, work_mj);
    if (!std::isfinite(output.syringe_kpa) || output.syringe_kpa < -101.325 ||
        !std::isfinite(output.bevel_kpa)) {
      worst.kpa = std::numeric_limits<double>::infinity();
    }
    worst.kpa = std::max(worst.kpa, std::abs(output.syringe_kpa));
    worst.force_n = std::max(worst.force_n, std::abs(output.reaction_n));
    worst.liquid_ml = std::max(worst.liquid_ml, std::abs(TotalLiquidMl(state) - liquid_ml));
    worst.air_ml = std::max(worst.air_ml, std::abs(TotalAirMl(state) - air_ml));
    worst.iterations = std::max(worst.iterations, output.iterations);
  }
  return worst;
}

TEST(FluidStability, ThePlungerIsPassiveBoundedAndKeepsItsAccounts) {
  std::uint64_t index = 0;
  double least_mj = 0.0;
  int most_iterations = 0;
  for (const HardCase& c : HardCases()) {
    const Worst worst = PlayRandomly(c, index++, 3000);
    EXPECT_GT(worst.energy_mj, -1e-6) << c.name;
    EXPECT_LT(worst.force_n, 1.01 * 56.0 * c.coupling_n_per_mm) << c.name;
    EXPECT_TRUE(std::isfinite(worst.kpa)) << c.name;
    EXPECT_LT(worst.liquid_ml, 1e-11) << c.name;
    EXPECT_LT(worst.air_ml, 1e-11) << c.name;
    EXPECT_LT(worst.iterations, 80) << c.name;
    least_mj = std::min(least_mj, worst.energy_mj);
    most_iterations = std::max(most_iterations, worst.iterations);
  }
  std::printf("  least energy %.3g mJ, at most %d iterations\n", least_mj, most_iterations);
}

TEST(FluidStability, APressingForceGetsNoEnergyBack) {
  for (const double dt_s : {1.0 / 4000.0, 1.0 / 250.0}) {
    for (const double air : {0.0, 0.2, 1.0}) {
      HardCase c;
      c.dt_s = dt_s;
      c.air_share = air;
      const FluidModel model = ModelOf(c);
      FluidState state = model.NewState();
      RandomStream random(9, "force");
      FluidInput input = In(kBlocked);
      double work_mj = 0.0;
      double least_mj = 0.0;
      for (int n = 0; n < 5000; ++n) {
        if (random.Uniform() < 10.0 * dt_s) input.hand_n = random.Uniform(-20.0, 40.0);
        if (random.Uniform() < 5.0 * dt_s) {
          input.bevel[0].tissue = random.Uniform() < 0.5 ? kBlocked : kSpace;
        }
        const double before_mm = state.plunger_mm;
        const FluidOutput output = model.Step(state, input, dt_s);
        work_mj += input.hand_n * (output.plunger_mm - before_mm);
        least_mj = std::min(least_mj, work_mj);
      }
      EXPECT_GT(least_mj, -1e-6) << dt_s << " " << air;
    }
  }
}

TEST(FluidStability, InputsThatAreNotNumbersDoNotSpread) {
  const FluidModel model = ModelOf({});
  FluidState state = model.NewState();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  FluidInput input;
  for (const double bad : {nan, inf, -inf, 1e300, -1e300}) {
    for (const Drive drive : {Drive::kForce, Drive::kPosition}) {
      input.drive = drive;
      input.hand_n = input.hand_mm = input.hand_mm_per_s = bad;
      input.coupling_n_s_per_mm = bad;
      input.bevel = {{{1000, bad}, {-7, bad}}};
      input.tip_mm.setConstant(bad);
      input.heart_cycles = input.breath_level = bad;
      const FluidOutput output = model.Step(state, input, 1e-3);
      EXPECT_TRUE(std::isfinite(output.plunger_mm)) << bad;
      EXPECT_TRUE(std::isfinite(output.reaction_n)) << bad;
      EXPECT_TRUE(std::isfinite(output.syringe_kpa)) << bad;
      EXPECT_TRUE(std::isfinite(state.tissue[0].centre_mm[0])) << bad;
    }
  }
  EXPECT_TRUE(std::isfinite(model.Step(state, Pressed(kSpace, 1.0), 1e-3).syringe_kpa));
}

TEST(FluidStability, AStepTakesNoMemory) {
  const FluidModel model = ModelOf({.name = "bubble", .friction_n = 1.0, .air_share = 0.1});
  FluidState state = model.NewState();
  RandomHand hand(state.plunger_mm, 1);
  FluidInput input = Held(kBlocked, state.plunger_mm, 5.0);
  const long before = acus::testing_support::num_allocations;
  for (int n = 0; n < 4000; ++n) {
    hand.Move(input, 1e-3);
    input.bevel[0].tissue = n / 100 % 6;
    input.hub = n / 700 % 3 == 0 ? Hub::kSyringe : n / 700 % 3 == 1 ? Hub::kOpen : Hub::kStylet;
    model.Step(state, input, 1e-3);
  }
  EXPECT_EQ(acus::testing_support::num_allocations - before, 0);
  // Over changes of the hub, too, nothing is lost.
  const FluidState start = model.NewState();
  EXPECT_NEAR(TotalLiquidMl(state), TotalLiquidMl(start), 1e-11);
  EXPECT_NEAR(TotalAirMl(state), TotalAirMl(start), 1e-11);
}

TEST(FluidStability, StepsOfAnyLengthStayFinite) {
  const FluidModel model = ModelOf({.name = "bubble", .air_share = 0.1});
  FluidState state = model.NewState();
  for (const double dt_s : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), 1e-9, 1.0, 1e9}) {
    const FluidOutput output = model.Step(state, Pressed(kSpace, 5.0), dt_s);
    EXPECT_TRUE(std::isfinite(output.syringe_kpa) && std::isfinite(output.plunger_mm)) << dt_s;
  }
  EXPECT_NEAR(TotalLiquidMl(state), TotalLiquidMl(model.NewState()), 1e-12);
}

TEST(FluidStability, APulledPlungerBoilsTheLiquidBeforeItTearsIt) {
  const FluidModel model = ModelOf({});
  FluidState state = model.NewState();
  FluidOutput output;
  for (int n = 0; n < 1000; ++n) output = model.Step(state, Held(kBlocked, 0.0, 100.0), 1e-3);
  EXPECT_GT(output.syringe_kpa, -100.4);
  EXPECT_LT(output.syringe_kpa, -98.9);
  EXPECT_NEAR(output.reaction_n, -99.0 * model.syringe().AreaMlPerMm(), 0.3);
}

TEST(FluidStability, ThePlungerDoesNotComeOut) {
  const FluidModel model = ModelOf({});
  FluidState state = model.NewState();
  FluidOutput output;
  for (int n = 0; n < 5000; ++n) output = model.Step(state, Pressed(kPool, -60.0), 1e-3);
  EXPECT_NEAR(output.plunger_mm, 0.0, 0.05);
}

// A space that hardly yields, in long steps: the pressure rises to that of the thumb, not beyond.
TEST(FluidStability, AStiffSpaceFillsWithoutOvershoot) {
  FluidTable table = TestTable();
  table.tissues[kSpace].space_compliance_ml_per_kpa = 1e-5;
  const FluidModel model(table, IdealSyringe(), {}, Tuohy16G());
  FluidState state = model.NewState();
  const double thumb_kpa = 5.0 / model.syringe().AreaMlPerMm();
  for (int n = 0; n < 200; ++n) {
    FluidInput input = Pressed(kSpace, 5.0);
    input.coupling_n_s_per_mm = 1.0;
    EXPECT_LT(model.Step(state, input, 4e-3).bevel_kpa, 1.001 * thumb_kpa) << n;
  }
  EXPECT_NEAR(state.bevel_kpa, thumb_kpa, 1e-3 * thumb_kpa);
}

TEST(FluidStability, ThePlungerStopsAtTheEndOfTheBarrel) {
  const FluidModel model = ModelOf({});
  FluidState state = model.NewState();
  FluidOutput output;
  for (int n = 0; n < 5000; ++n) output = model.Step(state, Pressed(kOpenTissue, 60.0), 1e-3);
  EXPECT_NEAR(output.plunger_mm, model.syringe().StrokeMm(), 0.05);
  EXPECT_NEAR(output.reaction_n, 60.0, 1e-6);
  EXPECT_NEAR(output.flow_ml_per_s, 0.0, 1e-6);
}

}  // namespace
}  // namespace acus::fluid
