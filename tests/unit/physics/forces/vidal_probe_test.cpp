#include "acus/physics/forces/probe/vidal_probe.h"

#include <gmock/gmock.h>

#include "support/force_scenes.h"

namespace acus::forces {
namespace {

using Eigen::Vector3d;
using testing_support::DrivenProbe;
using testing_support::ShippedTable;

/// Flat skin at z = 0 (-300 HU), a rib of radius 6 mm along y at (0, 14) in x and z (300 HU).
struct Rib : HuField {
  double HuAt(const Vector3d& p) const noexcept override {
    const double soft = std::clamp(-300.0 + 400.0 * p.z(), -1000.0, 50.0);
    const double bone = 300.0 + 300.0 * (6.0 - std::hypot(p.x(), p.z() - 14.0));
    return std::max(soft, std::min(bone, 1000.0));
  }
  double ResolutionMm() const noexcept override { return 0.7; }
};

class ProbeTest : public testing::Test {
 protected:
  const ProbeForce& MoveTo(const Vector3d& to, double speed_mm_per_s = 30.0) {
    const Vector3d way = to - place_mm;
    const int steps =
        std::max(1, static_cast<int>(std::ceil(way.norm() / (0.001 * speed_mm_per_s))));
    const Vector3d from = place_mm;
    for (int i = 1; i <= steps; ++i) {
      place_mm = from + way * i / steps;
      Step();
    }
    return driven.last;
  }
  const ProbeForce& Step() {
    const Vector3d before_n = driven.last.force_in_ct_n;
    driven.Step(time_s += 0.001, place_mm);
    largest_jump_n = std::max(largest_jump_n, (driven.last.force_in_ct_n - before_n).norm());
    return driven.last;
  }
  const ProbeForce& Rest() {
    for (int i = 0; i < 300; ++i) Step();
    return driven.last;
  }

  Rib body;
  VidalProbe model{ShippedTable("vidal.json"), body};
  DrivenProbe driven{model};
  Vector3d place_mm{30.0, 0.0, -5.0};
  double time_s = 0.0;
  double largest_jump_n = 0.0;
};

TEST_F(ProbeTest, SkinIsASpring) {
  MoveTo({30, 0, 5});
  Rest();
  EXPECT_TRUE(driven.last.on_skin);
  EXPECT_FALSE(driven.last.on_bone);
  EXPECT_TRUE(driven.last.force_in_ct_n.isApprox(Vector3d(0, 0, -0.4 * 5.0), 1e-3));
  MoveTo({30, 0, -1});
  EXPECT_EQ(driven.last.force_in_ct_n.norm(), 0.0);
  EXPECT_FALSE(driven.last.on_skin);
}

// Above the rib (top at z = 8) the stiffness rises from 0.4 to 2.0 N/mm, without a jump.
TEST_F(ProbeTest, BoneOnTheLineRaisesTheStiffness) {
  MoveTo({0, 0, -5});
  MoveTo({0, 0, 7.9});
  Rest();
  const double at_bone_n = -driven.last.force_in_ct_n.z();
  EXPECT_NEAR(at_bone_n, 0.4 * 7.9, 5e-3);
  MoveTo({0, 0, 9.0});
  Rest();
  EXPECT_TRUE(driven.last.on_bone);
  EXPECT_NEAR(driven.last.bone_mm, 1.0, 0.01);
  EXPECT_NEAR(-driven.last.force_in_ct_n.z(), 0.4 * 9.0 + 1.6 * 1.0, 0.02);
  EXPECT_LT(largest_jump_n, 0.1);  // 2 N/mm times 0.03 mm, and the damping.
}

// Section 3.3.1 as printed: on bone the proxy is where the line from the skin's proxy to the device
// enters it; F = (0.4 + 1.6) N/mm times the way to it. The fall from 0.4 * 8 N at contact is
// smooth.
TEST_F(ProbeTest, AsPrintedTheProxyIsMovedOntoBone) {
  ForceTable table = ShippedTable("vidal.json");
  table.vidal.probe.moves_proxy = true;
  const VidalProbe printed(table, body);
  DrivenProbe drive{printed};
  double t = 0.0;
  double largest_change_n = 0.0;
  double before_n = 0.0;
  const auto press_to = [&](double from_mm, double to_mm) {
    for (int n = 0; n <= 400; ++n) {
      drive.Step(t += 0.001, {0, 0, from_mm + (to_mm - from_mm) * std::min(1.0, n / 100.0)});
      const double force_n = drive.last.force_in_ct_n.norm();
      largest_change_n = std::max(largest_change_n, std::abs(force_n - before_n));
      before_n = force_n;
    }
  };
  press_to(-5.0, 7.9);
  EXPECT_NEAR(before_n, 0.4 * 7.9, 0.01);
  press_to(7.9, 9.0);
  EXPECT_TRUE(drive.last.on_bone);
  EXPECT_NEAR(drive.last.bone_mm, 1.0, 0.01);
  EXPECT_NEAR(before_n, 2.0 * 1.0, 0.02);  // Two springs: 0.4 * 9 + 1.6 * 1.
  EXPECT_LT(largest_change_n, 0.3);        // 3.2 N would be the jump.
  press_to(9.0, 7.0);
  EXPECT_FALSE(drive.last.on_bone);
  EXPECT_NEAR(before_n, 0.4 * 7.0, 0.01);
  // Aside of the rib's top the force stays parallel to that of the skin.
  for (int n = 0; n <= 400; ++n) drive.Step(t += 0.001, {2.5 * n / 400.0, 0, 7.0});
  for (int n = 0; n <= 400; ++n) drive.Step(t += 0.001, {2.5, 0, 7.0 + 3.0 * n / 400.0});
  for (int n = 0; n <= 400; ++n) drive.Step(t += 0.001, {2.5, 0, 10.0});
  EXPECT_TRUE(drive.last.on_bone);
  const Vector3d to_skin = drive.state.skin.at_in_ct_mm - Vector3d(2.5, 0, 10.0);
  EXPECT_LT(drive.last.force_in_ct_n.normalized().cross(to_skin.normalized()).norm(), 1e-3);
}

// The rib is felt when the probe slides over it, from the side and without a jump.
TEST_F(ProbeTest, ARibIsFeltWhileSliding) {
  MoveTo({30, 0, 9.0});
  MoveTo({-30, 0, 9.0});
  EXPECT_LT(largest_jump_n, 0.2);
  MoveTo({0, 0, 9.0});
  Rest();
  EXPECT_TRUE(driven.last.on_bone);
  EXPECT_GT(-driven.last.force_in_ct_n.z(), 0.4 * 9.0 + 1.0);
}

TEST_F(ProbeTest, ATrackerJumpIsSpreadAndBounded) {
  place_mm = {0, 0, -5};
  Step();
  place_mm = {0, 0, 10.0};  // 15 mm in one sample, through skin and into the rib.
  Step();
  EXPECT_TRUE(driven.last.on_bone);
  EXPECT_LT(driven.last.force_in_ct_n.norm(), 0.05);
  double before_n = 0.0;
  for (int i = 0; i < 200; ++i) {
    Step();
    ASSERT_GE(driven.last.force_in_ct_n.norm(), before_n - 1e-9);
    before_n = driven.last.force_in_ct_n.norm();
  }
  EXPECT_NEAR(before_n, 0.4 * 10.0 + 1.6 * 2.0, 0.05);
  MoveTo({0, 0, 60.0});
  EXPECT_LE(driven.last.force_in_ct_n.norm(), 15.0 + 1e-9);
}

TEST_F(ProbeTest, LostSamplesAreHeldAndFade) {
  MoveTo({30, 0, 5});
  Rest();
  const double held_n = driven.last.force_in_ct_n.norm();
  ProbeInput lost;
  lost.valid = false;
  lost.time_s = time_s + 0.05;
  EXPECT_EQ(model.Step(driven.state, lost).force_in_ct_n.norm(), held_n);
  lost.time_s = time_s + 0.2;
  EXPECT_NEAR(model.Step(driven.state, lost).force_in_ct_n.norm(), 0.5 * held_n, 1e-9);
  lost.time_s = time_s;
  model.Step(driven.state, lost);
  EXPECT_EQ(driven.state.num_time_back, 1);
  ProbeInput bad;
  bad.time_s = time_s + 0.3;
  bad.ct_from_probe.translation() = Vector3d(NAN, 0, 0);
  EXPECT_EQ(model.Step(driven.state, bad).force_in_ct_n.norm(), 0.0);
  EXPECT_EQ(driven.state.num_rejected, 1);
}

}  // namespace
}  // namespace acus::forces
