#include "acus/physics/tissue/probe_contact.h"

#include <gtest/gtest.h>

#include "acus/physics/tissue/tissue_model.h"
#include "support/fem_needle_scene.h"

namespace acus::tissue {
namespace {

using testing_support::FemScene;
using testing_support::SceneOptions;

SceneOptions WithProbe(double radius_mm = 0.0) {
  SceneOptions options;
  options.cells = {8, 8, 6};
  options.contact.probe = ProbeFace{40.0, 16.0, radius_mm};
  return options;
}

/// The middle of the face at this depth below the top, looking down.
Eigen::Isometry3d Probe(double depth_mm, double turn = 0.0) {
  Eigen::Isometry3d ct_from_probe = Eigen::Isometry3d::Identity();
  ct_from_probe.linear().col(0) = Eigen::Vector3d::UnitX();
  ct_from_probe.linear().col(1) = -Eigen::Vector3d::UnitZ();
  ct_from_probe.linear().col(2) = Eigen::Vector3d::UnitY();
  ct_from_probe.rotate(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()));
  ct_from_probe.translation() = Eigen::Vector3d(0.5, -0.5, 60.0 - depth_mm);
  return ct_from_probe;
}

ToolSample Sample(FemScene& scene, double probe_mm, double turn = 0.0) {
  ToolSample sample;
  sample.time_s = scene.time_s += 1e-3;
  sample.tip_in_ct_mm = {0.3, 18.7, 90.0};
  sample.axis_in_ct = {0, 0, -1};
  sample.probe_valid = true;
  sample.ct_from_probe = Probe(probe_mm, turn);
  return sample;
}

TEST(ProbeFace, FallsBackOnAConvexFace) {
  EXPECT_EQ((ProbeFace{40, 10, 0}.SurfaceMm(15.0)), 0.0);
  EXPECT_NEAR((ProbeFace{40, 10, 50}.SurfaceMm(30.0)), -10.0, 1e-12);
  EXPECT_TRUE(std::isfinite(ProbeFace({40, 10, 5}).SurfaceMm(20.0)));
}

TEST(ProbeContact, PressesOnlyAndAsFarAsItIsPressed) {
  FemScene scene(WithProbe());
  double last_n = 0.0;
  for (int step = -20; step <= 60; ++step) {
    const double depth_mm = 0.1 * step;
    scene.model.Step(scene.state, Sample(scene, depth_mm));
    const double pressed_n = scene.state.probe_force.force_in_ct_n.z();
    if (depth_mm <= 0.0) {
      EXPECT_EQ(pressed_n, 0.0);
      EXPECT_EQ(scene.state.probe_force.num_nodes, 0);
    } else {
      EXPECT_GT(pressed_n, last_n);  // On the probe, upwards.
    }
    last_n = pressed_n;
  }
  const auto pressing = [&scene] {
    int count = 0;
    for (std::size_t s = 0; s < scene.state.probe.node_of_slot.size(); ++s) {
      count += scene.state.contact.SlotForceN(1 + static_cast<int>(s)) > 0.0;
    }
    return count;
  };
  EXPECT_EQ(scene.state.probe_force.num_nodes, pressing());
  EXPECT_GE(scene.state.probe_force.num_nodes, 8);
  // Every node under the face is as deep as the face.
  const ContactState& contact = scene.state.contact;
  for (std::size_t s = 0; s < scene.state.probe.node_of_slot.size(); ++s) {
    if (scene.state.probe.node_of_slot[s] < 0) continue;
    const int slot = 1 + static_cast<int>(s);
    const Eigen::Vector3d moved =
        scene.model.system().DisplacementMm(contact, contact.slot_place(slot));
    EXPECT_GT(moved.dot(contact.slot_direction(slot)), 6.0 - 1e-9);
    if (contact.SlotForceN(slot) > 0.0) {
      EXPECT_NEAR(moved.dot(contact.slot_direction(slot)), 6.0, 1e-9);
    }
  }
  // Just off the skin nodes are still followed, but none of them presses.
  scene.model.Step(scene.state, Sample(scene, -0.3));
  EXPECT_EQ(scene.state.probe_force.num_nodes, 0);
  EXPECT_EQ(scene.state.probe_force.deepest_mm, 0.0);
  // Off the skin nothing is left: the tissue does not hold on to it.
  scene.model.Step(scene.state, Sample(scene, -1.0));
  EXPECT_EQ(scene.state.probe_force.force_in_ct_n, Eigen::Vector3d::Zero());
}

TEST(ProbeContact, AConvexFacePressesItsMiddleFirst) {
  FemScene flat(WithProbe());
  FemScene convex(WithProbe(30.0));
  for (int step = 0; step < 20; ++step) {
    flat.model.Step(flat.state, Sample(flat, 2.0));
    convex.model.Step(convex.state, Sample(convex, 2.0));
  }
  EXPECT_GT(convex.state.probe_force.num_nodes, 0);
  EXPECT_LT(convex.state.probe_force.num_nodes, flat.state.probe_force.num_nodes);
  EXPECT_LT(convex.state.probe_force.force_in_ct_n.z(), flat.state.probe_force.force_in_ct_n.z());
}

TEST(ProbeContact, OneNodeThatIsPressedIsTouch) {
  SceneOptions options = WithProbe();
  options.contact.probe = ProbeFace{40.0, 6.0, 25.0};  // Narrower than the distance of the nodes.
  FemScene scene(options);
  const TissueModel model(FemTissue{scene.model, nullptr});
  TissueState state = model.NewState();
  int of_one_node = 0;
  for (int step = -10; step < 60; ++step) {
    const TissueForce force = model.Step(state, Sample(scene, 0.02 * step));
    EXPECT_EQ(force.touched, force.num_probe_nodes > 0) << step;
    of_one_node += force.num_probe_nodes == 1;
  }
  EXPECT_GT(of_one_node, 0);
}

TEST(ProbeContact, TurningTheProbeBackGivesTheSameForce) {
  FemScene scene(WithProbe());
  for (int step = 0; step < 10; ++step) scene.model.Step(scene.state, Sample(scene, 4.0));
  const Eigen::Vector3d before = scene.state.probe_force.force_in_ct_n;
  for (int step = 0; step < 60; ++step) {
    scene.model.Step(scene.state, Sample(scene, 4.0, 0.2 * std::sin(0.1 * step)));
  }
  for (int step = 0; step < 10; ++step) scene.model.Step(scene.state, Sample(scene, 4.0));
  EXPECT_LT((scene.state.probe_force.force_in_ct_n - before).norm(), 1e-10 * before.norm());
}

TEST(ProbeContact, PressedSkinPushesTheNeedleUnderIt) {
  // The needle is in; the probe comes down beside it and takes the tissue along.
  FemScene scene(WithProbe());
  ToolSample sample;
  const auto step = [&](double needle_mm, double probe_mm) {
    sample = Sample(scene, probe_mm);
    sample.tip_in_ct_mm = {1.3, 12.0, 60.0 - needle_mm};
    return scene.model.Step(scene.state, sample);
  };
  for (int n = -10; n <= 250; ++n) step(0.1 * n, -5.0);
  for (int n = 250; n >= 240; --n) step(0.1 * n, -5.0);
  const double before_n = step(24.0, -5.0).friction_n;
  for (int n = -50; n <= 50; ++n) step(24.0, 0.1 * n);
  const double after_n = step(24.0, 5.0).friction_n;
  EXPECT_LT(after_n, before_n - 0.02);  // Tissue moves inwards past the shaft, and pulls it in.
  EXPECT_GT(scene.state.probe_force.force_in_ct_n.z(), 0.1);
}

TEST(ProbeContact, LostTrackingHoldsThenLetsGo) {
  FemScene scene(WithProbe());
  for (int step = 0; step < 10; ++step) scene.model.Step(scene.state, Sample(scene, 3.0));
  const double pressed_n = scene.state.probe_force.force_in_ct_n.z();
  EXPECT_GT(pressed_n, 0.0);
  ToolSample lost = Sample(scene, 3.0);
  lost.probe_valid = false;
  lost.time_s += 0.05;
  scene.model.Step(scene.state, lost);
  EXPECT_NEAR(scene.state.probe_force.force_in_ct_n.z(), pressed_n, 1e-9);
  lost.time_s += 0.2;
  scene.model.Step(scene.state, lost);
  EXPECT_EQ(scene.state.probe_force.force_in_ct_n.z(), 0.0);
  // A pose that is not one counts as lost.
  ToolSample rubbish = lost;
  rubbish.probe_valid = true;
  rubbish.time_s += 1e-3;
  rubbish.ct_from_probe.translation().x() = std::numeric_limits<double>::quiet_NaN();
  scene.model.Step(scene.state, rubbish);
  EXPECT_EQ(scene.state.probe_force.num_nodes, 0);
}

TEST(ProbeContact, AJumpDeepIntoTheBodyStaysBounded) {
  FemScene scene(WithProbe());
  for (int step = 0; step < 50; ++step) {
    scene.model.Step(scene.state, Sample(scene, step % 2 == 0 ? 50.0 : -5.0));
    ASSERT_TRUE(scene.state.probe_force.force_in_ct_n.allFinite());
    ASSERT_LE(scene.state.probe_force.force_in_ct_n.norm(), 48 * ProbeContact::kLargestNodeN);
  }
}

/// Stored in the tissue by a probe that has been at this pose for a while, N mm.
double EnergyAt(FemScene& scene, const Eigen::Isometry3d& ct_from_probe) {
  ToolSample sample = Sample(scene, 0.0);
  for (int n = 0; n < 12; ++n) {  // A few new nodes a step.
    sample.time_s = scene.time_s += 1e-3;
    sample.ct_from_probe = ct_from_probe;
    scene.model.Step(scene.state, sample);
  }
  double energy_n_mm = 0.0;
  for (std::size_t s = 0; s < scene.state.probe.node_of_slot.size(); ++s) {
    if (scene.state.probe.node_of_slot[s] < 0) continue;
    energy_n_mm += 0.5 * scene.state.contact.SlotForceN(1 + static_cast<int>(s)) *
                   scene.state.probe.cleared_mm[s];
  }
  return energy_n_mm;
}

// A device that holds the probe gets back what it put in, and no more: its force and torque are the
// slope of the energy by each motion.
TEST(ProbeContact, ForceAndTorqueAreTheSlopeOfTheStoredEnergy) {
  for (const double radius_mm : {0.0, 45.0}) {
    FemScene scene(WithProbe(radius_mm));
    Eigen::Isometry3d pose = Probe(5.0, 0.06);
    pose.rotate(Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitX()));
    EnergyAt(scene, pose);
    const ProbeForce felt = scene.state.probe_force;
    ASSERT_GT(felt.force_in_ct_n.z(), 0.5);
    for (int axis = 0; axis < 6; ++axis) {
      constexpr double kStep = 1e-4;
      const auto moved = [&](double step) {
        Eigen::Isometry3d there = pose;
        const Eigen::Vector3d along = Eigen::Vector3d::Unit(axis % 3);
        if (axis < 3) {
          there.translation() += step * along;
        } else {
          there.linear() = Eigen::AngleAxisd(step, along).toRotationMatrix() * pose.linear();
        }
        return EnergyAt(scene, there);
      };
      const double slope = (moved(kStep) - moved(-kStep)) / (2.0 * kStep);
      const double force = axis < 3 ? felt.force_in_ct_n[axis] : felt.torque_in_ct_n_mm[axis - 3];
      EXPECT_NEAR(force, -slope, 1e-4 * felt.force_in_ct_n.norm() * (axis < 3 ? 1.0 : 20.0))
          << radius_mm << ' ' << axis;
    }
  }
}

}  // namespace
}  // namespace acus::tissue
