#include "acus/physics/needle/rod.h"

#include <cfenv>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "acus/base/core/error.h"
#include "elastica.h"
#include "rods.h"

namespace acus::needle {
namespace {

using Eigen::Vector3d;
using testing_support::Channel;
using testing_support::Elastica;
using testing_support::Input;
using testing_support::kBending;
using testing_support::kLengthMm;
using testing_support::kTwist;
using testing_support::Rod;
using testing_support::TipLoad;
using testing_support::TipMm;

RodState Solved(const RodModel& model, const RodInput& input) {
  RodState state = model.NewState();
  const RodResult result = model.Solve(state, input);
  EXPECT_TRUE(result.converged()) << NameOf(result.status) << ", " << result.iterations;
  return state;
}

// The reference itself, against published values: Bisshopp and Drucker (1945), F L^2 / EI = 1, 10.
TEST(ElasticaReference, IsThePublishedOne) {
  EXPECT_NEAR(Elastica(1.0, 0.0, 1.0).across, 0.30172, 1e-5);
  EXPECT_NEAR(Elastica(10.0, 0.0, 5.0).across, 0.81061, 1e-5);
}

TEST(RodModel, BendsAsTheElasticaWhateverTheNumberOfNodes) {
  for (const double force_n : {0.5, 1.0, 5.0, 20.0}) {
    const double load = force_n * kLengthMm * kLengthMm / kBending;
    const auto exact = Elastica(load, 0.0, std::min(load, 1.5 * std::sqrt(load)));
    for (const int num_nodes : {15, 25, 50, 100}) {
      const RodModel model = Rod(num_nodes, 1e-5);
      const RodLoad tip = TipLoad({force_n, 0.0, 0.0});
      const RodState state = Solved(model, Input({}, {&tip, 1}));
      const double elements = num_nodes - 1;
      const double bound_mm =
          0.3 * exact.across * kLengthMm / (elements * elements);  // 0.15 % at 15
      EXPECT_NEAR(TipMm(state).x(), exact.across * kLengthMm, bound_mm) << num_nodes;
      EXPECT_NEAR(TipMm(state).z(), exact.along * kLengthMm, bound_mm) << num_nodes;
      EXPECT_NEAR(TipMm(state).y(), 0.0, 1e-9);
      // Held in balance: the hand feels the load and its moment.
      EXPECT_NEAR(state.last.base_force_n.x(), force_n, 1e-9);
      EXPECT_NEAR(state.last.base_torque_n_mm.y(), force_n * TipMm(state).z(),
                  1e-6 * force_n * 150);
    }
  }
}

TEST(RodModel, ErrorFallsWithTheSquareOfTheSpacing) {
  const double load = 1.0 * kLengthMm * kLengthMm / kBending;
  const double exact_mm = kLengthMm * Elastica(load, 0.0, load).across;
  const RodLoad tip = TipLoad({0.0, 1.0, 0.0});
  const auto error = [&](int elements) {
    return TipMm(Solved(Rod(elements + 1, 1e-8), Input({}, {&tip, 1}))).y() - exact_mm;
  };
  EXPECT_NEAR(error(8) / error(16), 4.0, 0.05);
  EXPECT_NEAR(error(16) / error(32), 4.0, 0.05);
}

// Euler, clamped and free: pi^2 EI / (4 L^2). A needle pushed along its axis stays straight below
// it and bends as the elastica above it; the tip's load is a hair off the axis, as any real one.
TEST(RodModel, BucklesAtEulersLoadAndThenBendsAsTheElastica) {
  const double euler_n =
      std::numbers::pi * std::numbers::pi * kBending / (4 * kLengthMm * kLengthMm);
  for (const int num_nodes : {15, 25, 100}) {
    const RodModel model = Rod(num_nodes, 1e-6);
    RodState state = model.NewState();
    const auto tip_at = [&](double share) {
      const RodLoad push = TipLoad({1e-5 * euler_n, 0.0, -share * euler_n});
      EXPECT_TRUE(model.Solve(state, Input({}, {&push, 1})).converged()) << share;
      return TipMm(state);
    };
    EXPECT_LT(tip_at(0.98).x(), 0.2);
    // Southwell: 1 / deflection falls linearly to 0 at the buckling load.
    const double at_90 = 1.0 / tip_at(0.90).x();
    const double at_95 = 1.0 / tip_at(0.95).x();
    const double critical = 0.95 + 0.05 * at_95 / (at_90 - at_95);
    EXPECT_NEAR(critical, 1.0, 0.002) << num_nodes;
    const double load = 1.1 * std::numbers::pi * std::numbers::pi / 4.0;
    const auto bent = Elastica(1e-5 * load, load, 1.3);
    ASSERT_GT(bent.across, 0.3);
    EXPECT_NEAR(tip_at(1.1).x(), kLengthMm * bent.across, 0.02 * kLengthMm) << num_nodes;
    EXPECT_NEAR(tip_at(1.1).z(), kLengthMm * bent.along, 0.02 * kLengthMm) << num_nodes;
  }
}

// A quarter circle, clamped, loaded across its plane: bends and twists.
// Castigliano: F R^3 (pi / 4 / EI + (3 pi / 4 - 2) / GJ).
TEST(RodModel, BendsAndTwistsFromACurvedRestShape) {
  RodProperties ring;
  ring.length_mm = 60.0;
  ring.bending_n_mm2 = 40000.0;
  ring.twist_n_mm2 = 25000.0;
  const double radius_mm = ring.length_mm / (std::numbers::pi / 2);
  ring.rest_curvature_per_mm = {1.0 / radius_mm, 0.0, 0.0};
  RodOptions options;
  options.num_nodes = 100;
  options.tolerance_mm = 1e-7;
  const RodModel model(ring, options);
  const RodState rest = Solved(model, {});
  EXPECT_NEAR((TipMm(rest) - Vector3d(0.0, -radius_mm, radius_mm)).norm(), 0.0, 1e-9);
  const RodLoad across{ring.length_mm, {0.01, 0.0, 0.0}};
  const RodState bent = Solved(model, Input({}, {&across, 1}));
  const double by_theory = 0.01 * std::pow(radius_mm, 3) *
                           (std::numbers::pi / 4 / ring.bending_n_mm2 +
                            (3 * std::numbers::pi / 4 - 2) / ring.twist_n_mm2);
  EXPECT_NEAR(TipMm(bent).x() / by_theory, 1.0, 1e-3);
}

// Hetenyi: a long beam on springs, loaded across at its end, gives way by 2 F lambda / k.
TEST(RodModel, LiesOnSpringsAsTheBeamOnAnElasticFoundation) {
  const double k = 0.5;
  const double lambda = std::pow(k / (4 * kBending), 0.25);
  ASSERT_GT(lambda * kLengthMm, 5.0);
  const RodLoad tip = TipLoad({0.05, 0.0, 0.0});
  for (const int num_nodes : {25, 50, 100}) {
    const auto channel = Channel(0.0, num_nodes - 1, k);
    const RodState state = Solved(Rod(num_nodes), Input(channel, {&tip, 1}));
    // Piecewise constant curvature and lumped springs: (lambda h)^2.
    const double h = kLengthMm / (num_nodes - 1);
    EXPECT_NEAR(TipMm(state).x() / (2 * 0.05 * lambda / k), 1.0, 0.3 * std::pow(lambda * h, 2))
        << num_nodes;
  }
}

TEST(RodModel, SlidesFreelyAlongTheAxisOfAContactOnly) {
  const RodModel model = Rod(25);
  auto channel = Channel(50.0, 20, 1.0);
  for (RodContact& contact : channel) contact.anchor_mm.z() -= 7.0;
  EXPECT_EQ(Solved(model, Input(channel)).last.base_force_n.norm(), 0.0);
  RodContact held;
  held.arc_mm = kLengthMm;
  held.anchor_mm = {0.0, 0.0, kLengthMm - 1.0};
  held.stiffness_n_per_mm = 0.5;
  channel.push_back(held);
  EXPECT_NEAR(Solved(model, Input(channel)).last.base_force_n.z(), -0.5, 1e-9);
}

// The work of the hand is what the energy gains: force and torque are its slopes.
TEST(RodModel, BaseForceAndTorqueAreTheSlopesOfTheEnergy) {
  const RodModel model = Rod(25, 1e-9);
  auto channel = Channel(60.0, 15, 0.4);
  for (RodContact& contact : channel) contact.anchor_mm.x() += 0.001 * contact.arc_mm;
  RodContact tip;
  tip.arc_mm = kLengthMm;
  tip.anchor_mm = {2.0, 1.0, 148.0};
  tip.stiffness_n_per_mm = 0.5;
  channel.push_back(tip);
  const RodLoad load{70.0, {0.1, -0.3, 0.2}};
  const auto energy = [&](const Vector3d& shift_mm, const Vector3d& turn_rad) {
    RodInput input = Input(channel, {&load, 1});
    input.base.position_mm = Vector3d(3.0, -4.0, 1.0) + shift_mm;
    input.base.orientation = TurnQuaternion(turn_rad) * TurnQuaternion({0.05, 0.03, 0.2});
    return Solved(model, input).last;
  };
  const RodResult here = energy(Vector3d::Zero(), Vector3d::Zero());
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d e = Vector3d::Unit(axis);
    const double by_shift =
        (energy(1e-3 * e, {0, 0, 0}).energy_n_mm - energy(-1e-3 * e, {0, 0, 0}).energy_n_mm) / 2e-3;
    EXPECT_NEAR(-by_shift, here.base_force_n[axis], 1e-5);
    const double by_turn =
        (energy({0, 0, 0}, 1e-4 * e).energy_n_mm - energy({0, 0, 0}, -1e-4 * e).energy_n_mm) / 2e-4;
    EXPECT_NEAR(-by_turn, here.base_torque_n_mm[axis], 1e-4);
  }
}

TEST(RodModel, TurnsWithTheWorld) {
  const RodModel model = Rod(25, 1e-7);
  const Eigen::Isometry3d turn =
      Eigen::Translation3d(30.0, -200.0, 70.0) * Eigen::AngleAxisd(2.1, Vector3d(0.48, 0.6, 0.64));
  auto channel = Channel(80.0, 10, 0.3);
  for (RodContact& contact : channel) contact.anchor_mm += Vector3d(1.0, 2.0, 0.0);
  RodLoad load{kLengthMm, {0.2, 0.1, -0.3}};
  const RodState here = Solved(model, Input(channel, {&load, 1}));
  for (RodContact& contact : channel) {
    contact.anchor_mm = turn * contact.anchor_mm;
    contact.free_axis = turn.linear() * contact.free_axis;
  }
  load.force_n = turn.linear() * load.force_n;
  RodInput input = Input(channel, {&load, 1});
  input.base.position_mm = turn.translation();
  input.base.orientation = Eigen::Quaterniond(turn.linear());
  const RodState there = Solved(model, input);
  for (std::size_t i = 0; i < here.point.size(); ++i) {
    EXPECT_NEAR((turn * here.point[i].position_mm - there.point[i].position_mm).norm(), 0, 1e-6);
  }
}

// A hub on springs settles where rod and springs balance.
TEST(RodModel, ASprungHubYieldsByForceOverStiffness) {
  const RodModel model = Rod(25, 1e-7);
  const RodLoad load = TipLoad({0.4, 0.0, 0.0});
  RodInput input = Input({}, {&load, 1});
  input.base.sprung = true;
  input.base.position_mm = {5.0, 6.0, 7.0};
  input.base.stiffness_n_per_mm = 0.8;
  input.base.stiffness_n_mm_per_rad = 2000.0;
  const RodState state = Solved(model, input);
  EXPECT_NEAR((state.point[0].position_mm - Vector3d(5.5, 6.0, 7.0)).norm(), 0.0, 1e-5);
  EXPECT_NEAR(state.last.base_force_n.x(), 0.4, 1e-7);
  const double lever_mm = TipMm(state).z() - 7.0;
  EXPECT_NEAR(std::atan2(state.point[0].tangent.x(), state.point[0].tangent.z()),
              0.4 * lever_mm / 2000.0, 1e-6);
}

// However soft: a load that the springs nearly balance by themselves.
TEST(RodModel, AHubMayBeSprungSoftly) {
  const RodModel model = Rod(25);
  const RodLoad load = TipLoad({1e-6, 0.0, 0.0});
  RodInput input = Input({}, {&load, 1});
  input.base.sprung = true;
  input.base.stiffness_n_per_mm = 0.01;
  input.base.stiffness_n_mm_per_rad = 0.05;
  RodState state = model.NewState();
  EXPECT_NE(model.Solve(state, input).status, RodStatus::kRejected);
  for (double RodBase::*stiffness :
       {&RodBase::stiffness_n_per_mm, &RodBase::stiffness_n_mm_per_rad}) {
    RodInput none = input;
    none.base.*stiffness = 0.0;
    EXPECT_EQ(model.Solve(state, none).status, RodStatus::kRejected);
  }
}

// In steps too small to be a jump.
TEST(RodModel, AClampedHubThatOnlyTurnsTakesTheNeedleAlong) {
  const RodModel model = Rod(25, 1e-6);
  const auto channel = Channel(40.0, 30, 0.3);
  RodInput input = Input(channel);
  RodState state = Solved(model, input);
  for (int n = 1; n <= 10; ++n) {
    input.base.orientation = Eigen::AngleAxisd(0.005 * n, Vector3d::UnitY());
    EXPECT_TRUE(model.Solve(state, input).converged());
    EXPECT_NEAR(std::atan2(state.point[0].tangent.x(), state.point[0].tangent.z()), 0.005 * n,
                1e-9);
  }
  const RodState at_once = Solved(model, input);
  EXPECT_GT(
      (at_once.point[8].position_mm - Solved(model, Input(channel)).point[8].position_mm).norm(),
      0.1);
  for (std::size_t i = 0; i < state.point.size(); ++i) {
    EXPECT_NEAR((state.point[i].position_mm - at_once.point[i].position_mm).norm(), 0.0, 1e-4) << i;
  }
}

TEST(RodModel, TheOrderOfContactsChangesNoBit) {
  const RodModel model = Rod(25);
  auto channel = Channel(40.0, 30, 0.3);
  for (RodContact& contact : channel)
    contact.anchor_mm.x() += 0.0003 * contact.arc_mm * contact.arc_mm;
  std::vector<RodLoad> loads{{90.0, {0.1, 0.0, 0.0}}, {90.0, {0.0, 0.2, 0.0}}, {10.0, {0.3, 0, 0}}};
  const RodState one = Solved(model, Input(channel, loads));
  std::reverse(channel.begin(), channel.end());
  std::swap(channel[3], channel[11]);
  std::reverse(loads.begin(), loads.end());
  const RodState other = Solved(model, Input(channel, loads));
  for (std::size_t i = 0; i < one.point.size(); ++i) {
    EXPECT_EQ(one.point[i].position_mm, other.point[i].position_mm);
  }
  EXPECT_EQ(one.last.base_torque_n_mm, other.last.base_torque_n_mm);
}

TEST(RodModel, InterpolatesAlongItsArcs) {
  const RodModel model = Rod(8, 1e-8);
  const RodLoad load = TipLoad({2.0, 0.0, 0.0});
  const RodState state = Solved(model, Input({}, {&load, 1}));
  for (int i = 0; i < 8; ++i) {
    const double arc_mm = i * model.spacing_mm();
    EXPECT_NEAR((model.PositionMm(state, arc_mm) - state.point[i].position_mm).norm(), 0, 1e-9);
    EXPECT_NEAR((model.Tangent(state, arc_mm) - state.point[i].tangent).norm(), 0, 1e-9);
  }
  const Vector3d slope =
      (model.PositionMm(state, 50.001) - model.PositionMm(state, 49.999)) / 0.002;
  EXPECT_NEAR((slope - model.Tangent(state, 50.0)).norm(), 0.0, 1e-6);
}

/// A contact without free axis acts in 3D, and no step divides by its length.
TEST(RodModel, AContactWithoutFreeAxisRaisesNoInvalidOperation) {
  const RodModel rod = Rod(21);
  RodState state = rod.NewState();
  RodContact contact;
  contact.arc_mm = 100.0;
  contact.anchor_mm = {1.0, 0.0, 101.0};
  contact.stiffness_n_per_mm = 10.0;
  std::feclearexcept(FE_ALL_EXCEPT);
  rod.Solve(state, Input(std::span(&contact, 1)));
  EXPECT_EQ(std::fetestexcept(FE_INVALID | FE_DIVBYZERO), 0);
  EXPECT_EQ(state.action[0].free_axis.norm(), 0.0);
}

TEST(RodModel, RefusesWhatIsNoRod) {
  const RodProperties good{100.0, 1000.0, 800.0, Vector3d::Zero()};
  const auto refused = [](const RodProperties& p, const RodOptions& o) {
    EXPECT_THROW(RodModel(p, o), InputError);
  };
  for (const double bad : {0.0, -1.0, std::nan("")}) {
    RodProperties p = good;
    p.length_mm = bad;
    refused(p, {});
    p = good;
    p.bending_n_mm2 = bad;
    refused(p, {});
    p = good;
    p.twist_n_mm2 = bad;
    refused(p, {});
    refused(good, {.tolerance_mm = bad});
  }
  refused(good, {.num_nodes = 1});
  refused(good, {.max_contacts = -1});
  refused(good, {.max_iterations = 0});
  EXPECT_NO_THROW(RodModel(good, {.num_nodes = 2}));
}

}  // namespace
}  // namespace acus::needle
