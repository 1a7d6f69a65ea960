// A needle in 3D finite elements where it is hard. Bounds: docs/models/tissue_contact.md.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>

#include "core/random.h"
#include "support/fem_needle_scene.h"
#include "support/fresh_contact.h"

namespace acus::testing_support {
long NumAllocations();  // In tissue_contact_system_test.cpp, which counts them.
}

namespace acus::tissue {
namespace {

using forces::NeedleForce;
using testing_support::CompareWithFresh;
using testing_support::FemScene;
using testing_support::SceneOptions;

constexpr double kLargestN = 30.0;

SceneOptions Layers() {
  SceneOptions options;
  options.inner_below_mm = 30.0;
  options.bone_below_mm = 10.0;
  return options;
}

TEST(FemNeedleStability, AJumpOf50MmIsBoundedAndForgotten) {
  FemScene steady(Layers());
  FemScene jumping(Layers());
  steady.Move(-1.0, 25.0);
  jumping.StepAt(-25.0);
  double largest_n = 0.0;
  for (int n = 0; n < 40; ++n)
    largest_n = std::max(largest_n, jumping.StepAt(25.0).force_in_ct_n.norm());
  EXPECT_LT(largest_n, 2.0);  // The skin gives way at 1.5 N.
  EXPECT_EQ(jumping.state.contact.num_points(), steady.state.contact.num_points());
  EXPECT_NEAR(jumping.StepAt(25.0).cutting_n, steady.StepAt(25.0).cutting_n, 0.1);
  for (const double depth_mm : {-25.0, 75.0, 25.0, -25.0, 25.0}) {
    for (int n = 0; n < 3; ++n) {
      const NeedleForce force = jumping.StepAt(depth_mm);
      ASSERT_LE(force.force_in_ct_n.norm(), kLargestN + 1e-9) << depth_mm;
    }
  }
  for (int n = 0; n < 5; ++n) jumping.StepAt(-25.0);
  EXPECT_EQ(jumping.StepAt(-25.0).force_in_ct_n, Eigen::Vector3d::Zero());
}

TEST(FemNeedleStability, AJumpAsideLosesContactWithinTheLargestForce) {
  FemScene scene(Layers());
  scene.Move(-1.0, 30.0);
  const NeedleForce force = scene.StepAt(30.0, 20.0, 20.0);
  EXPECT_LE(force.force_in_ct_n.norm(), kLargestN + 1e-9);
  scene.Move(-1.0, 25.0);
  scene.StepAt(25.0, 0.3, -0.7, 3.0);  // 70 degrees.
  EXPECT_GE(scene.state.num_lost, 1);
  EXPECT_EQ(scene.state.phase, NeedlePhase::kFree);
  // Still inside: nothing is felt until it has been outside.
  EXPECT_EQ(scene.StepAt(25.0).force_in_ct_n, Eigen::Vector3d::Zero());
  scene.StepAt(-2.0);
  scene.Move(-2.0, 10.0);
  EXPECT_NE(scene.state.phase, NeedlePhase::kFree);
}

TEST(FemNeedleStability, RandomHandlingStaysWithinBoundsAndExact) {
  FemScene scene(Layers());
  RandomStream random(31, "handling");
  double depth_mm = -5.0;
  double x_mm = 0.3;
  double tilt = 0.0;
  double worst_n = 0.0;
  double worst_breach = 0.0;
  int inside = 0;
  const long before = testing_support::NumAllocations();
  long counted = 0;
  for (int step = 0; step < 20000; ++step) {
    const double kind = random.Uniform();
    depth_mm += kind < 0.9 ? random.Uniform(-1.0, 1.05) : random.Uniform(-10.0, 10.0);
    depth_mm = std::clamp(depth_mm, -10.0, 60.0);
    x_mm = 0.99 * x_mm + random.Uniform(-0.1, 0.1);
    tilt = std::clamp(tilt + random.Uniform(-0.02, 0.02), -0.6, 0.6);
    const NeedleForce force = scene.StepAt(depth_mm, x_mm, -0.7, tilt);
    ASSERT_TRUE(force.force_in_ct_n.allFinite());
    ASSERT_LE(force.force_in_ct_n.norm(), kLargestN + 1e-9);
    ASSERT_LE(force.cutting_n, 0.8 + 1e-9);
    ASSERT_LE(force.puncture_n, 1.5 + 1e-9);
    ASSERT_LE(std::abs(force.friction_n), 0.03 * 80.0);
    counted = testing_support::NumAllocations() - before;
    if (scene.state.phase == NeedlePhase::kInside) ++inside;
  }
  EXPECT_EQ(counted, 0);
  EXPECT_GT(inside, 5000);
  EXPECT_EQ(scene.state.contact.counts().num_fallbacks, 0);
  EXPECT_EQ(scene.state.contact.counts().num_weak_pivots, 0);
  EXPECT_EQ(scene.state.contact.num_refactors(), 0);
  EXPECT_LT(scene.state.contact.largest_residual_mm(), 1e-10);
  for (int step = 0; step < 200; ++step) {
    // Solve once more what the state asks for, and once densely.
    ContactState state = scene.state.contact;
    scene.StepAt(30.0 + 10.0 * std::sin(0.1 * step), x_mm, -0.7, 0.2);
    state = scene.state.contact;
    scene.model.system().Solve(state);
    const auto fresh = CompareWithFresh(scene.model.system(), state);
    worst_n = std::max(worst_n, fresh.force_error_n);
    worst_breach = std::max(worst_breach, fresh.breach);
  }
  EXPECT_LT(worst_n, 1e-11);
  EXPECT_LT(worst_breach, 1e-10);
}

TEST(FemNeedleStability, AlongNodesEdgesAndFacesItIsAsNextToThem) {
  // A mesh without jitter: (0, 0) is a line of nodes and edges, (5, 0) one of faces.
  SceneOptions options;
  options.jitter = 0.0;
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(0, 0), {10, 0}, {5, 0}, {5, 5}, {-10, -10}}) {
    FemScene on(options);
    FemScene beside(options);
    for (int step = -10; step <= 400; ++step) {
      const NeedleForce a = on.StepAt(0.1 * step, at.x(), at.y());
      const NeedleForce b = beside.StepAt(0.1 * step, at.x() + 1e-7, at.y() + 1e-7);
      ASSERT_LT((a.force_in_ct_n - b.force_in_ct_n).norm(), 1e-4)
          << step << " at " << at.transpose();
    }
  }
}

TEST(FemNeedleStability, SpacingFarBelowTheElementsChangesLittle) {
  // Elements of 11 mm; points every 0.5 to 3 mm.
  SceneOptions options = Layers();
  options.contact.contact_spacing_mm = 3.0;
  FemScene coarse(options);
  std::vector<double> in_n;
  for (int step = -10; step <= 280; ++step) in_n.push_back(coarse.StepAt(0.1 * step).AxialN());
  for (const double spacing_mm : {1.5, 0.8}) {
    options.contact.contact_spacing_mm = spacing_mm;
    options.contact.max_points = 128;
    FemScene fine(options);
    for (int step = -10; step <= 280; ++step) {
      const double axial_n = fine.StepAt(0.1 * step).AxialN();
      if (step <= 60) continue;
      ASSERT_NEAR(axial_n, in_n[static_cast<std::size_t>(step + 10)], 0.08) << step;
    }
  }
}

TEST(FemNeedleStability, ForcesDoNotJumpWhenPointsComeAndGo) {
  FemScene scene(Layers());
  double last_n = 0.0;
  double largest_jump_n = 0.0;
  bool was_event = true;
  for (int step = -100; step <= 2 * 2500; ++step) {
    // In to 25 mm and out again, 0.01 mm at a time.
    const double depth_mm = 0.01 * (step <= 2500 ? step : 5000 - step);
    const NeedleForce force = scene.StepAt(depth_mm);
    if (force.event == forces::NeedleEvent::kNone && !was_event) {
      largest_jump_n = std::max(largest_jump_n, std::abs(force.AxialN() - last_n));
    }
    was_event = force.event != forces::NeedleEvent::kNone;
    last_n = force.AxialN();
  }
  std::printf("largest change of force in 0.01 mm: %.4f N\n", largest_jump_n);
  EXPECT_LT(largest_jump_n, 0.03);
}

TEST(FemNeedleStability, NodesOutOfReachHoldStill) {
  // Only nodes within 11 mm of the axis are known; the needle leaves that corridor at a slant.
  SceneOptions options;
  options.reach_mm = 11.0;
  FemScene scene(options);
  double last_n = 0.0;
  double largest_jump_n = 0.0;
  for (int step = -10; step <= 900; ++step) {
    const double depth_mm = 0.05 * step;
    const NeedleForce force = scene.StepAt(depth_mm, 0.5 * depth_mm, 0.0, 0.5);
    ASSERT_TRUE(force.force_in_ct_n.allFinite());
    ASSERT_LT(force.force_in_ct_n.norm(), 3.0);
    if (scene.state.phase == NeedlePhase::kInside && depth_mm > 8.0) {
      largest_jump_n = std::max(largest_jump_n, std::abs(force.AxialN() - last_n));
    }
    last_n = force.AxialN();
  }
  EXPECT_GT(scene.state.num_out_of_reach, 5);
  EXPECT_LT(largest_jump_n, 0.1);
}

/// The same tissue with its nodes and tetrahedra in another order.
FemScene Shuffled(const SceneOptions& options, std::uint64_t seed) {
  FemScene scene(options);
  RandomStream random(seed, "order");
  const auto shuffle = [&](Eigen::Index count) {
    std::vector<Eigen::Index> order(static_cast<std::size_t>(count));
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t i = order.size() - 1; i > 0; --i) {
      std::swap(order[i],
                order[static_cast<std::size_t>(random.Uniform() * static_cast<double>(i + 1))]);
    }
    return order;
  };
  const mesh::TetraMesh old = scene.mesh;
  const auto new_of_node = shuffle(old.nodes_mm.cols());
  const auto new_of_tetrahedron = shuffle(old.tetrahedra.cols());
  for (std::size_t n = 0; n < new_of_node.size(); ++n) {
    scene.mesh.nodes_mm.col(new_of_node[n]) = old.nodes_mm.col(static_cast<Eigen::Index>(n));
    scene.mesh.fixed_nodes[static_cast<std::size_t>(new_of_node[n])] = old.fixed_nodes[n];
  }
  for (std::size_t t = 0; t < new_of_tetrahedron.size(); ++t) {
    const Eigen::Index at = new_of_tetrahedron[t];
    scene.mesh.tissue[static_cast<std::size_t>(at)] = old.tissue[t];
    for (int c = 0; c < 4; ++c) {
      scene.mesh.tetrahedra(c, at) = static_cast<int>(
          new_of_node[static_cast<std::size_t>(old.tetrahedra(c, static_cast<Eigen::Index>(t)))]);
    }
  }
  scene.compliance = testing_support::ComplianceOf(
      scene.mesh, testing_support::SceneElasticity(options), options.storage,
      [&](const Eigen::Vector3d& x) { return x.head<2>().norm() <= options.reach_mm; });
  scene.model = FemNeedleModel(
      scene.mesh, scene.compliance, testing_support::SceneElasticity(options),
      testing_support::SceneForces(), testing_support::SceneNeedle(), options.contact);
  scene.state = scene.model.NewState();
  return scene;
}

TEST(FemNeedleStability, RenumberedNodesAndElementsGiveTheSameForces) {
  FemScene scene(Layers());
  FemScene other = Shuffled(Layers(), 41);
  double worst = 0.0;
  for (int step = -10; step <= 900; ++step) {
    const double depth_mm = step <= 450 ? 0.1 * step : 45.0 + 5.0 * std::sin(0.05 * step);
    const NeedleForce a = scene.StepAt(depth_mm, 0.3, -0.7, 0.0002 * step);
    const NeedleForce b = other.StepAt(depth_mm, 0.3, -0.7, 0.0002 * step);
    ASSERT_EQ(a.event, b.event) << step;
    const double size_n = std::max(a.force_in_ct_n.norm(), 0.1);
    worst = std::max(worst, (a.force_in_ct_n - b.force_in_ct_n).norm() / size_n);
  }
  std::printf("renumbered: largest relative difference %.2g\n", worst);
  EXPECT_LT(worst, 1e-12);
}

TEST(FemNeedleStability, NoEnergyComesOutOfTheTissue) {
  // In the old channel the tissue is elastic and dry friction takes energy: over any closed cycle
  // of the hand the work done on it is positive, and just after the first half cycle it never gave
  // back more than was put in.
  FemScene scene(Layers());
  scene.Move(-1.0, 25.0);
  scene.Move(25.0, 15.0);
  double work_n_mm = 0.0;
  double least_n_mm = 0.0;
  double last_depth_mm = 15.0;
  NeedleForce last = scene.StepAt(15.0);
  RandomStream random(42, "energy");
  const double amplitude_mm[] = {0.05, 0.5, 2.0, 5.0};
  for (const double mm : amplitude_mm) {
    const double start_n_mm = work_n_mm;
    for (int step = 1; step <= 1600; ++step) {
      const double depth_mm = 15.0 + mm * std::sin(2.0 * std::numbers::pi * step / 400.0);
      const NeedleForce force = scene.StepAt(depth_mm);
      // The hand does -F . dx on the needle; implicit: the force at the end of the step.
      work_n_mm += force.AxialN() * (depth_mm - last_depth_mm);
      least_n_mm = std::min(least_n_mm, work_n_mm);
      last_depth_mm = depth_mm;
      last = force;
    }
    EXPECT_GE(work_n_mm - start_n_mm, -1e-9) << mm;
  }
  // What was stored when the cycles began: at most friction over its stretch, 0.6 N over 2 mm.
  EXPECT_GT(least_n_mm, -0.6);
  EXPECT_GT(work_n_mm, 1.0);
}

TEST(FemNeedleStability, StandingStillChangesNothing) {
  FemScene scene(Layers());
  scene.Move(-1.0, 33.0);
  for (int n = 0; n < 20; ++n) scene.StepAt(33.0, 0.3, -0.7, 0.1);
  const Eigen::Vector3d rest = scene.StepAt(33.0, 0.3, -0.7, 0.1).force_in_ct_n;
  for (int n = 0; n < 2000; ++n) {
    ASSERT_LT((scene.StepAt(33.0, 0.3, -0.7, 0.1).force_in_ct_n - rest).norm(), 1e-9) << n;
  }
  // Nor does it on bone.
  scene.Move(33.0, 52.0);
  for (int n = 0; n < 20; ++n) scene.StepAt(52.0);
  const NeedleForce on_bone = scene.StepAt(52.0);
  EXPECT_GT(on_bone.bone_n, 1.0);
  for (int n = 0; n < 2000; ++n) {
    ASSERT_LT((scene.StepAt(52.0).force_in_ct_n - on_bone.force_in_ct_n).norm(), 1e-9) << n;
  }
}

}  // namespace
}  // namespace acus::tissue
