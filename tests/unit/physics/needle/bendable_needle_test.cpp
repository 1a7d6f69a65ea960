#include "acus/physics/needle/bendable_needle.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"
#include "rods.h"

namespace acus::needle {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using testing_support::kBending;
using testing_support::kLengthMm;
using testing_support::kTwist;

BendableNeedle Needle(const BendableNeedleOptions& options = {}) {
  RodProperties properties;
  properties.length_mm = kLengthMm;
  properties.bending_n_mm2 = kBending;
  properties.twist_n_mm2 = kTwist;
  return {properties, options};
}

BendableNeedleInput In(double depth_mm, double advance_mm, double lean_rad = 0.0) {
  BendableNeedleInput input;
  input.tip_mm = {0.0, 0.0, depth_mm};
  input.hand = Eigen::AngleAxisd(lean_rad, Vector3d::UnitY());
  input.touches = depth_mm >= 0.0;
  input.advance_mm = advance_mm;
  input.tissue.stiffness_n_per_mm2 = 0.3;
  input.tissue.tissue = 4;
  return input;
}

TEST(BendableNeedle, StraightInAndOutIsStraightAndWithoutForce) {
  const BendableNeedle needle = Needle();
  BendableNeedleState state = needle.NewState();
  for (double z = -5.0; z < 0.0; z += 0.5) {
    EXPECT_EQ(needle.Step(state, In(z, 0.0)).hand_force_n, Vector3d::Zero());
    EXPECT_TRUE(state.path.empty());
    EXPECT_NEAR(state.rod.point.back().position_mm.z(), z, 1e-9);
  }
  needle.Step(state, In(0.0, 0.0));
  EXPECT_EQ(state.path.num_nodes, 1);
  for (int i = 1; i <= 400; ++i) {
    const BendableNeedleStep step = needle.Step(state, In(0.1 * i, 0.1));
    ASSERT_TRUE(step.rod.converged());
    ASSERT_LT(step.hand_force_n.norm() + step.hand_torque_n_mm.norm(), 1e-6);
  }
  EXPECT_NEAR(state.path.LengthMm(), 40.0, 1e-9);
  EXPECT_NEAR((state.rod.point.back().position_mm - Vector3d(0, 0, 40)).norm(), 0.0, 1e-6);
  for (int i = 399; i >= -20; --i) needle.Step(state, In(0.1 * i, -0.1));
  EXPECT_TRUE(state.path.empty());
  EXPECT_NEAR(state.rod.point.back().position_mm.z(), -2.0, 1e-9);
}

// Fig. 8, upper: 10 mm in, then the hand leans and goes on. Held there it pulls back; drawn out it
// is straight again.
TEST(BendableNeedle, LeaningBendsItPullsBackAndIsForgottenOutside) {
  const BendableNeedle needle = Needle();
  BendableNeedleState state = needle.NewState();
  for (int i = 0; i <= 100; ++i) needle.Step(state, In(0.1 * i, i == 0 ? 0.0 : 0.1));
  double lean_rad = 0.0;
  for (int i = 0; i < 100; ++i) needle.Step(state, In(10.0, 0.0, lean_rad += 0.0015));
  BendableNeedleStep step;
  for (int i = 0; i < 500; ++i) {
    step = needle.Step(state, In(10.0, 0.1, lean_rad));
    ASSERT_TRUE(step.rod.converged()) << i;
    ASSERT_LE(step.rod.iterations, 4) << i;
  }
  EXPECT_NEAR(state.path.LengthMm(), 60.0, 0.05);
  EXPECT_GT(state.path.tip().position_mm.x(), 1.0);
  // Turning the needle upright at the skin is what the torque wants.
  EXPECT_LT(step.hand_torque_n_mm.y(), -1.0);
  const Vector3d axis(std::sin(lean_rad), 0.0, std::cos(lean_rad));
  EXPECT_NEAR(step.hand_torque_n_mm.dot(axis), 0.0, 1e-9);
  for (int i = 0; i < 700 && !state.path.empty(); ++i) needle.Step(state, In(10.0, -0.1, lean_rad));
  ASSERT_TRUE(state.path.empty());
  needle.Step(state, In(-1.0, 0.0));
  EXPECT_NEAR((state.rod.point.back().position_mm - Vector3d(0, 0, -1)).norm(), 0.0, 1e-6);
}

TEST(BendableNeedle, ABevelBendsThePath) {
  BendableNeedleOptions options;
  options.bevel = {.curvature_per_mm = 0.002, .roll_rad = 0.0};
  const BendableNeedle needle = Needle(options);
  BendableNeedleState state = needle.NewState();
  for (int i = 0; i <= 800; ++i) needle.Step(state, In(0.1 * i, i == 0 ? 0.0 : 0.1));
  EXPECT_NEAR(state.path.tip().position_mm.x(), (1 - std::cos(0.16)) / 0.002, 0.1);
  EXPECT_NEAR(state.heading.x(), std::sin(0.16), 0.01);
}

TEST(BendableNeedle, ACopyContinuesWithTheSameBits) {
  const BendableNeedle needle = Needle();
  BendableNeedleState state = needle.NewState();
  for (int i = 0; i <= 100; ++i) needle.Step(state, In(0.1 * i, 0.1, 0.001 * i));
  BendableNeedleState copy = state;
  for (int i = 100; i <= 200; ++i) {
    needle.Step(state, In(0.1 * i, 0.1, 0.001 * i));
    needle.Step(copy, In(0.1 * i, 0.1, 0.001 * i));
  }
  EXPECT_EQ(state.rod.point.back().position_mm, copy.rod.point.back().position_mm);
  EXPECT_EQ(state.path.tip().position_mm, copy.path.tip().position_mm);
}

TEST(BendableNeedle, RefusesWhatIsNotFiniteAndKeepsItsShape) {
  const BendableNeedle needle = Needle();
  BendableNeedleState state = needle.NewState();
  for (int i = 0; i <= 100; ++i) needle.Step(state, In(0.1 * i, 0.1, 0.001 * i));
  const Vector3d tip_mm = state.rod.point.back().position_mm;
  const double length_mm = state.path.LengthMm();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int part = 0; part < 5; ++part) {
    BendableNeedleInput bad = In(10.0, 0.1, 0.1);
    if (part == 0) bad.tip_mm.x() = nan;
    if (part == 1) bad.hand.w() = nan;
    if (part == 2) bad.advance_mm = nan;
    if (part == 3) bad.tissue.stiffness_n_per_mm2 = -1.0;
    if (part == 4) bad.advance_mm = std::numeric_limits<double>::infinity();
    EXPECT_EQ(needle.Step(state, bad).rod.status, RodStatus::kRejected) << part;
  }
  EXPECT_EQ(state.rod.num_rejected, 5);
  EXPECT_EQ(state.rod.point.back().position_mm, tip_mm);
  EXPECT_EQ(state.path.LengthMm(), length_mm);
  BendableNeedleOptions options;
  options.path_spacing_mm = 0.0;
  EXPECT_THROW(Needle(options), InputError);
  for (int part = 0; part < 4; ++part) {
    for (const double value : {0.0, -1.0, nan}) {
      options = {};
      (part == 0   ? options.hand.stiffness_n_per_mm
       : part == 1 ? options.hand.stiffness_n_mm_per_rad
       : part == 2 ? options.coupling.tip_stiffness_n_per_mm
                   : options.kappa_n_per_mm) = value;
      EXPECT_THROW(Needle(options), InputError) << part << " " << value;
    }
  }
}

TEST(BendableNeedle, APathBegunDeepHasItsSkinBehindTheTip) {
  const BendableNeedle needle = Needle();
  BendableNeedleState state = needle.NewState();
  const BendableNeedleStep step = needle.Step(state, In(4.0, 4.0));
  EXPECT_NEAR(state.path.entry().position_mm.z(), 0.0, 1e-12);
  EXPECT_NEAR(state.path.LengthMm(), 4.0, 1e-12);
  EXPECT_LT(step.hand_force_n.norm(), 1e-9);
}

// The hand moves and turns with the needle 40 mm deep: what it puts in is what the needle stores.
TEST(BendableNeedle, WithAPotentialTheWorkOfTheHandIsTheEnergyStored) {
  BendableNeedleOptions options;
  options.hand_has_potential = true;
  options.rod.tolerance_mm = 1e-6;
  const BendableNeedle needle = Needle(options);
  BendableNeedleState state = needle.NewState();
  for (int i = 0; i <= 80; ++i) needle.Step(state, In(0.5 * i, i == 0 ? 0.0 : 0.5));
  BendableNeedleInput input = In(40.0, 0.0);
  BendableNeedleStep before = needle.Step(state, input);
  double work_n_mm = 0.0, moved_n_mm = 0.0, largest_n_mm = 0.0;
  for (int i = 1; i <= 8000; ++i) {
    const double t = 1e-3 * i;
    BendableNeedleInput next = input;
    next.tip_mm = Vector3d(5.0 * std::sin(2.0 * t), 4.0 * (1.0 - std::cos(3.0 * t)), 40.0);
    next.hand = Eigen::AngleAxisd(0.2 * std::sin(1.3 * t), Vector3d::UnitX()) *
                Eigen::AngleAxisd(0.3 * std::sin(1.9 * t), Vector3d::UnitY());
    const BendableNeedleStep now = needle.Step(state, next);
    ASSERT_TRUE(now.rod.converged());
    const Eigen::AngleAxisd turn(next.hand * input.hand.conjugate());
    const double work =
        -0.5 * ((before.hand_force_n + now.hand_force_n).dot(next.tip_mm - input.tip_mm) +
                (before.hand_torque_n_mm + now.hand_torque_n_mm).dot(turn.angle() * turn.axis()));
    work_n_mm += work;
    moved_n_mm += std::abs(work);
    largest_n_mm = std::max(largest_n_mm, now.rod.energy_n_mm);
    ASSERT_NEAR(work_n_mm, now.rod.energy_n_mm, 0.01) << i;  // 10 uJ.
    before = now;
    input = next;
  }
  EXPECT_GT(largest_n_mm, 5.0);
  EXPECT_GT(moved_n_mm, 50.0);
}

}  // namespace
}  // namespace acus::needle
