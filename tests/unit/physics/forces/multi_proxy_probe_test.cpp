#include "acus/physics/forces/probe/multi_proxy_probe.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/physics/forces/laws/occupancy_field.h"
#include "support/force_scenes.h"

namespace acus::forces {
namespace {

using Eigen::Vector3d;
using testing_support::DrivenPalpation;
using testing_support::FieldsOf;
using testing_support::ShippedTable;

/// Flat skin at z = 0 (-300 HU); bone (300 HU) below `bone_mm`.
struct Slab : HuField {
  double bone_mm = 1e3;
  double HuAt(const Vector3d& p) const noexcept override {
    return std::max(std::clamp(-300.0 + 400.0 * p.z(), -1000.0, 50.0),
                    std::clamp(300.0 + 400.0 * (p.z() - bone_mm), -1000.0, 1000.0));
  }
  double ResolutionMm() const noexcept override { return 0.7; }
};

/// A table without friction and damping, so that forces have closed forms.
ForceTable BareTable() {
  ForceTable table = ShippedTable("vidal.json");
  table.multi_proxy.skin.friction = 0.0;
  for (auto& structure : table.multi_proxy.structures) structure.repulsion.friction = 0.0;
  table.multi_proxy.damping_n_s_per_mm = 0.0;
  table.multi_proxy.smoothing_s = 0.0;
  table.multi_proxy.largest_force_n = 1e6;
  return table;
}

class PalpationTest : public testing::Test {
 protected:
  const ProbeForce& MoveTo(DrivenPalpation& driven, const Vector3d& to) {
    const Vector3d from = place_mm;
    for (int i = 1; i <= 400; ++i) {
      place_mm = from + (to - from) * i / 400.0;
      driven.Step(time_s += 0.001, place_mm);
    }
    return driven.last;
  }
  Slab body;
  Vector3d place_mm{0.0, 0.0, -3.0};
  double time_s = 0.0;
};

TEST_F(PalpationTest, AFlatFaceFeelsThePolynomialWhateverTheNumberOfProxies) {
  const ForceTable table = BareTable();
  const auto& skin = table.multi_proxy.skin;
  for (const int num : {1, 2, 7, 16, 64}) {
    const MultiProxyProbe model(table, ProbeFaceNodes(40.0, 12.0, 0.0, num), FieldsOf(table, body));
    DrivenPalpation driven{model};
    place_mm = {0, 0, -3};
    MoveTo(driven, {0, 0, 10});
    const double wanted_n = skin.a1_n_per_mm * 10.0 + skin.a2_n_per_mm2 * 100.0;
    EXPECT_NEAR(-driven.last.force_in_ct_n.z(), wanted_n, 1e-4) << num;
    EXPECT_LT(driven.last.force_in_ct_n.head<2>().norm(), 1e-6) << num;
    EXPECT_LT(driven.last.torque_in_ct_n_mm.norm(), 1e-3) << num;
    EXPECT_EQ(driven.last.num_on_skin, num);
    MoveTo(driven, {0, 0, -1});
    EXPECT_EQ(driven.last.force_in_ct_n.norm(), 0.0);
    EXPECT_FALSE(driven.last.on_skin);
  }
}

// Tilted by an angle in its plane, the depth is d + x sin: the mean over the face has a closed
// form.
TEST_F(PalpationTest, ATiltedFaceConvergesToTheIntegralOverIt) {
  const ForceTable table = BareTable();
  const double a1 = table.multi_proxy.skin.a1_n_per_mm;
  const double a2 = table.multi_proxy.skin.a2_n_per_mm2;
  const double length_mm = 40.0;
  const double tilt_rad = 0.2;
  const double depth_mm = 10.0;
  const double slope = std::sin(tilt_rad);
  const double force_n =
      a1 * depth_mm + a2 * (depth_mm * depth_mm + slope * slope * length_mm * length_mm / 12.0);
  const double torque_n_mm = std::cos(tilt_rad) * length_mm * length_mm / 12.0 *
                             (a1 * slope + 2.0 * a2 * depth_mm * slope);
  double before = 1e9;
  for (const int num : {4, 16, 64}) {
    const MultiProxyProbe model(table, ProbeFaceNodes(length_mm, 12.0, 0.0, num),
                                FieldsOf(table, body));
    DrivenPalpation driven{model};
    driven.ct_from_tool_turn =
        Eigen::AngleAxisd(-tilt_rad, Vector3d::UnitY()) * DrivenPalpation::BeamAlongZ();
    place_mm = {0, 0, -8};
    MoveTo(driven, {0, 0, depth_mm});
    const double off_n = std::abs(-driven.last.force_in_ct_n.z() - force_n);
    EXPECT_LT(off_n, 0.3 * before) << num;
    before = off_n + 1e-9;
    if (num == 64) {
      EXPECT_NEAR(-driven.last.force_in_ct_n.z(), force_n, 1e-3);
      EXPECT_NEAR(driven.last.torque_in_ct_n_mm.y(), torque_n_mm, 2e-3 * torque_n_mm);
    }
  }
}

TEST_F(PalpationTest, BoneUnderTheSkinIsFeltOnTop) {
  body.bone_mm = 6.0;
  const ForceTable table = BareTable();
  const MultiProxyProbe model(table, FingertipNodes(8.0, 1), FieldsOf(table, body));
  DrivenPalpation driven{model};
  MoveTo(driven, {0, 0, 5.9});
  EXPECT_FALSE(driven.last.on_bone);
  EXPECT_EQ(driven.last.structure, 0);
  MoveTo(driven, {0, 0, 8.0});
  EXPECT_TRUE(driven.last.on_bone);
  EXPECT_EQ(driven.last.structure, volume::LabelOf("bone"));
  EXPECT_NEAR(driven.last.bone_mm, 2.0, 1e-3);
  const auto& law = table.multi_proxy;
  const double wanted_n = law.skin.a1_n_per_mm * 8.0 + law.skin.a2_n_per_mm2 * 64.0 +
                          law.structures[0].repulsion.a1_n_per_mm * 2.0;
  EXPECT_NEAR(-driven.last.force_in_ct_n.z(), wanted_n, 5e-3);
}

// Pushed in by d and then aside: the proxies stay until the cone's edge, then follow on it.
TEST_F(PalpationTest, ProxiesStayInsideTheFrictionCone) {
  ForceTable table = BareTable();
  table.multi_proxy.skin.friction = 0.3;
  const MultiProxyProbe model(table, ProbeFaceNodes(40.0, 12.0, 0.0, 9), FieldsOf(table, body));
  DrivenPalpation driven{model};
  MoveTo(driven, {0, 0, 8});
  for (const double aside_mm : {0.5, 1.5, 2.3, 4.0, 20.0}) {
    MoveTo(driven, {aside_mm, 0, 8});
    const Vector3d& f = driven.last.force_in_ct_n;
    const double share = f.head<2>().norm() / -f.z();
    EXPECT_LE(share, 0.3 + 1e-5) << aside_mm;
    EXPECT_NEAR(share, std::min(0.3, aside_mm / 8.0), 1e-4) << aside_mm;
    EXPECT_LT(f.x(), 0.0);
  }
}

TEST_F(PalpationTest, AFingertipFeelsMoreOfItsSurfaceTheDeeperItIs) {
  const ForceTable table = BareTable();
  const MultiProxyProbe model(table, FingertipNodes(8.0, 64), FieldsOf(table, body));
  DrivenPalpation driven{model};
  int before = 0;
  for (const double z_mm : {1.0, 3.0, 6.0, 8.5}) {
    MoveTo(driven, {0, 0, z_mm});
    // Equal areas: the share of the hemisphere in the skin is its height.
    EXPECT_NEAR(driven.last.num_on_skin / 64.0, std::min(1.0, z_mm / 8.0), 1.0 / 64.0);
    EXPECT_GT(driven.last.num_on_skin, before);
    before = driven.last.num_on_skin;
  }
}

TEST_F(PalpationTest, ATrackerJumpIsSpreadAndBounded) {
  body.bone_mm = 6.0;
  const ForceTable table = ShippedTable("vidal.json");
  const MultiProxyProbe model(table, ProbeFaceNodes(40.0, 12.0, 0.0, 16), FieldsOf(table, body));
  DrivenPalpation driven{model};
  driven.Step(time_s += 0.001, {0, 0, -5});
  double before_n = driven.Step(time_s += 0.001, {0, 0, 15}).force_in_ct_n.norm();
  EXPECT_LT(before_n, 0.1);
  for (int i = 0; i < 300; ++i) {
    const double now_n = driven.Step(time_s += 0.001, {0, 0, 15}).force_in_ct_n.norm();
    ASSERT_GE(now_n, before_n - 1e-9);
    before_n = now_n;
  }
  EXPECT_NEAR(before_n, 15.0, 1e-6);
}

TEST_F(PalpationTest, ATouchFromBeforeTheRecordingIsFelt) {
  const ForceTable table = ShippedTable("vidal.json");
  const MultiProxyProbe model(table, ProbeFaceNodes(40.0, 12.0, 0.0, 16), FieldsOf(table, body));
  const VidalProbe vidal(table, body);
  DrivenPalpation driven{model};
  testing_support::DrivenProbe one{vidal};
  for (int i = 0; i < 500; ++i) {
    driven.Step(0.001 * i, {0, 0, 8});
    one.Step(0.001 * i, {0, 0, 8});
  }
  EXPECT_NEAR(driven.last.skin_mm, 8.0, 1e-2);
  EXPECT_NEAR(-driven.last.force_in_ct_n.z(), 0.2 * 8.0 + 0.02 * 64.0, 1e-2);
  EXPECT_NEAR(-one.last.force_in_ct_n.z(), 0.4 * 8.0, 1e-2);
}

TEST_F(PalpationTest, BadSamplesAreAsInEveryModel) {
  const ForceTable table = BareTable();
  const MultiProxyProbe model(table, ProbeFaceNodes(40.0, 12.0, 0.0, 16), FieldsOf(table, body));
  DrivenPalpation driven{model};
  MoveTo(driven, {0, 0, 5});
  const double held_n = driven.last.force_in_ct_n.norm();
  ProbeInput input;
  input.ct_from_probe.linear() = DrivenPalpation::BeamAlongZ();
  input.ct_from_probe.translation() = Vector3d(0, 0, 5);
  input.valid = false;
  input.time_s = time_s + 0.2;  // Half way down the ramp.
  EXPECT_NEAR(model.Step(driven.state, input).force_in_ct_n.norm(), 0.5 * held_n, 1e-9);
  input.valid = true;
  input.time_s = time_s;
  model.Step(driven.state, input);
  EXPECT_EQ(driven.state.num_time_back, 1);
  input.time_s = time_s + 0.3;
  for (const double bad : {0.0, 1e12, static_cast<double>(NAN)}) {  // No rotation.
    input.ct_from_probe.linear() = bad * Eigen::Matrix3d::Identity();
    EXPECT_EQ(model.Step(driven.state, input).force_in_ct_n.norm(), 0.0);
    input.time_s += 0.001;
  }
  input.ct_from_probe.linear().setIdentity();
  input.ct_from_probe.translation().x() = INFINITY;
  EXPECT_EQ(model.Step(driven.state, input).force_in_ct_n.norm(), 0.0);
  EXPECT_EQ(driven.state.num_rejected, 4);
}

TEST_F(PalpationTest, ASavedStateGivesTheSameBits) {
  body.bone_mm = 6.0;
  const ForceTable table = ShippedTable("vidal.json");
  const MultiProxyProbe model(table, ProbeFaceNodes(40.0, 12.0, 60.0, 25), FieldsOf(table, body));
  const auto way = RandomMotion({.to_mm = 15.0, .across_mm = 20.0}, 4.0, 7);
  DrivenPalpation first{model};
  DrivenPalpation second{model};
  std::vector<ProbeForce> forces(4000);
  for (std::size_t i = 0; i < forces.size(); ++i) {
    if (i == 2000) second.state = first.state;
    forces[i] = first.Step(0.001 * static_cast<double>(i), way(0.001 * static_cast<double>(i)));
  }
  for (std::size_t i = 2000; i < forces.size(); ++i) {
    second.Step(0.001 * static_cast<double>(i), way(0.001 * static_cast<double>(i)));
    ASSERT_EQ(second.last.force_in_ct_n, forces[i].force_in_ct_n);
    ASSERT_EQ(second.last.torque_in_ct_n_mm, forces[i].torque_in_ct_n_mm);
  }
}

TEST(PalpationTool, HasTheProxiesThatWereRequested) {
  const PalpationTool face = ProbeFaceNodes(50.0, 10.0, 60.0, 13);
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < face.num_nodes; ++i) {
    const Vector3d& p = face.node_mm[static_cast<std::size_t>(i)];
    EXPECT_LE(std::abs(p.x()), 25.0);
    EXPECT_LE(std::abs(p.z()), 5.0);
    EXPECT_NEAR(std::hypot(p.x(), p.y() + 60.0), 60.0, 1e-9);
    sum += p;
  }
  EXPECT_NEAR(sum.x(), 0.0, 1e-9);
  EXPECT_NEAR(sum.z(), 0.0, 1e-9);
  for (int i = 0; i < 20; ++i) {
    EXPECT_NEAR(
        (FingertipNodes(8.0, 20).node_mm[static_cast<std::size_t>(i)] + Vector3d(0, 8, 0)).norm(),
        8.0, 1e-9);
  }
  for (const int bad : {-1, 0, 65}) {
    EXPECT_THROW(ProbeFaceNodes(50.0, 10.0, 0.0, bad), InputError) << bad;
    EXPECT_THROW(FingertipNodes(8.0, bad), InputError) << bad;
  }
  EXPECT_THROW(ProbeFaceNodes(0.0, 10.0, 0.0, 4), InputError);
  EXPECT_THROW(ProbeFaceNodes(50.0, -1.0, 0.0, 4), InputError);
  EXPECT_THROW(ProbeFaceNodes(50.0, 10.0, 20.0, 4), InputError);
  EXPECT_THROW(FingertipNodes(0.0, 4), InputError);
}

// The surface that labels give is within half a voxel of the ball that they were made from.
TEST(OccupancyField, ASurfaceFromLabelsIsNearTheTruth) {
  volume::Geometry geometry;
  geometry.size = {44, 44, 44};
  geometry.origin_mm = {-21.5, -21.5, -21.5};
  volume::LabelMap labels(geometry);
  for (int k = 0; k < 44; ++k) {
    for (int j = 0; j < 44; ++j) {
      for (int i = 0; i < 44; ++i) {
        labels.At(i, j, k) = std::hypot(i - 21.5, j - 21.5, k - 21.5) < 15.0 ? 7 : 3;
      }
    }
  }
  const OccupancyField field(labels, std::bitset<256>().set(7));
  for (int i = 0; i < 200; ++i) {
    const double height = 1.0 - (2.0 * i + 1.0) / 200.0;
    const double turn = 2.399963 * i;
    const double aside = std::sqrt(1.0 - height * height);
    const Vector3d direction(aside * std::cos(turn), aside * std::sin(turn), height);
    const double crossing =
        field.FirstCrossing(20.0 * direction, Vector3d::Zero(), OccupancyField::kSurface);
    EXPECT_NEAR(20.0 * (1.0 - crossing), 15.0, 0.5);
  }
  EXPECT_LT(field.HuAt(Vector3d(0, 0, 100)), 0.0);
  EXPECT_EQ(field.HuAt(Vector3d::Zero()), OccupancyField::kFull);
}

}  // namespace
}  // namespace acus::forces
