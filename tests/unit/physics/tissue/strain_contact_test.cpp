#include "acus/physics/tissue/strain_contact.h"

#include <cstring>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "references/finite_strain.h"
#include "support/fem_needle_scene.h"

namespace acus::tissue {
namespace {

using namespace testing_support;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kEdgeMm = 40.0;

/// A box of stiffening tissue, all of whose nodes are in the compliance and in the region: what the
/// steps find is then the answer of the static solver.
struct StiffScene {
  mesh::TetraMesh mesh;
  mechanics::ElasticityTable table;
  mechanics::Compliance compliance;
  StrainSettings settings;

  explicit StiffScene(mechanics::HyperelasticLaw law = {mechanics::LawKind::kFung, 0, 0, 4.0}) {
    const double half_mm = 0.5 * kEdgeMm;
    mesh = BoxMesh({5, 5, 5}, {-half_mm, -half_mm, 0.0}, {half_mm, half_mm, kEdgeMm}, 0.1);
    Fix(mesh, [](const Eigen::Vector3d& x) { return x.z() < 1e-6; });
    table = ElasticLabels({{4, {0.02, 0.45}}});
    table.law[4] = law;
    compliance = ComplianceOf(
        mesh, table, mechanics::Storage::kDouble, [](const Eigen::Vector3d&) { return true; },
        mechanics::ElementKind::kAveragedDilatation);
    settings.corridor = {{0, 0, kEdgeMm + 5.0}, {0, 0, 10.0}, 12.0};
    settings.max_nodes = StrainSettings::kMostNodes;
    settings.iterations = 30;
    settings.tolerance_mm = 1e-7;
  }

  /// @param skin_n  What pierces the skin.
  FemNeedleModel Model(double skin_n = 1.5, bool linear = false) const {
    FemContactSettings contact;
    if (!linear) contact.strain = settings;
    forces::ForceTable forces = SceneForces();
    forces.tissue[4].membrane.puncture_n = skin_n;
    return {mesh, compliance, table, forces, SceneNeedle(), contact};
  }
};

ToolSample AtDepth(double time_s, double depth_mm, double x_mm = 0.3) {
  ToolSample sample;
  sample.time_s = time_s;
  sample.tip_in_ct_mm = {x_mm, -0.7, kEdgeMm - depth_mm};
  sample.axis_in_ct = -Eigen::Vector3d::UnitZ();
  return sample;
}

/// Steps to a depth and holds there.
forces::NeedleForce Press(const FemNeedleModel& model, FemNeedleState& state, double depth_mm,
                          int hold = 20) {
  forces::NeedleForce force;
  double time_s = state.started ? state.time_s : 0.0;
  for (double d = -0.5; d < depth_mm; d += 0.05)
    force = model.Step(state, AtDepth(time_s += 1e-3, d));
  for (int n = 0; n < hold; ++n) force = model.Step(state, AtDepth(time_s += 1e-3, depth_mm));
  return force;
}

const mechanics::HyperelasticLaw kHeldLaws[] = {
    {mechanics::LawKind::kFung, 0, 0, 4.0},
    {.kind = mechanics::LawKind::kOgden, .ogden = {{{0.9, -8.0}, {0.1, 10.0}}}},
    {.kind = mechanics::LawKind::kKnowles,
     .exponent_b = 20.0,
     .power_n = 0.8,
     .fibres = {2e-3, 0.5, Eigen::Vector3d::UnitX()}}};
class HeldSkin : public testing::TestWithParam<mechanics::HyperelasticLaw> {};
INSTANTIATE_TEST_SUITE_P(Laws, HeldSkin, testing::ValuesIn(kHeldLaws));

TEST_P(HeldSkin, IsTheStaticSolution) {
  const StiffScene scene(GetParam());
  const FemNeedleModel model = scene.Model(10.0);
  ASSERT_EQ(model.strain()->region().num_nodes(), scene.compliance.num_nodes());
  mechanics::FiniteStrainSolver solver(scene.mesh, scene.table,
                                       mechanics::ElementKind::kAveragedDilatation);
  for (const double depth_mm : {1.0, 3.0, 6.0}) {
    FemNeedleState state = model.NewState();
    Press(model, state, depth_mm);
    ASSERT_EQ(state.phase, NeedlePhase::kOnSkin) << "the skin gave way before " << depth_mm;
    EXPECT_LT(state.strain.error_mm, 1e-6);
    const double force_n = state.contact.SlotForceN(0);
    const ContactPlace& place = state.contact.slot_place(0);
    Eigen::Matrix3Xd load = Eigen::Matrix3Xd::Zero(3, scene.mesh.nodes_mm.cols());
    for (int r = 0; r < place.num_rows; ++r) {
      load.col(scene.compliance.nodes()[static_cast<std::size_t>(place.row[r])]) +=
          place.weight[r] * force_n * state.contact.slot_direction(0);
    }
    const Eigen::Matrix3Xd u = solver.Solve(load).displacement_mm;
    double moved_mm = state.contact.slot_local_mm_per_n(0) * force_n;
    for (int r = 0; r < place.num_rows; ++r) {
      moved_mm += place.weight[r] *
                  state.contact.slot_direction(0).dot(
                      u.col(scene.compliance.nodes()[static_cast<std::size_t>(place.row[r])]));
    }
    // Of 6 mm; the region's compliance is stored in float.
    EXPECT_NEAR(moved_mm, state.depth_mm, 2e-5) << depth_mm;
    RecordProperty("error_mm", testing::PrintToString(moved_mm - state.depth_mm));
  }
}

TEST(StrainContact, StiffensAgainstTheLinearModel) {
  const StiffScene scene;
  const FemNeedleModel model = scene.Model(10.0);
  const FemNeedleModel linear = scene.Model(10.0, true);
  FemNeedleState state = model.NewState();
  FemNeedleState linear_state = linear.NewState();
  const double force_n = Press(model, state, 6.0).force_in_ct_n.z();
  const double linear_n = Press(linear, linear_state, 6.0).force_in_ct_n.z();
  EXPECT_GT(force_n, 1.1 * linear_n);
  EXPECT_LT(force_n, 2.0 * linear_n);
}

TEST(StrainContact, SmallIndentationIsLinear) {
  const StiffScene scene;
  const FemNeedleModel model = scene.Model(10.0);
  const FemNeedleModel linear = scene.Model(10.0, true);
  FemNeedleState state = model.NewState();
  FemNeedleState linear_state = linear.NewState();
  const double force_n = Press(model, state, 0.01).force_in_ct_n.z();
  const double linear_n = Press(linear, linear_state, 0.01).force_in_ct_n.z();
  EXPECT_NEAR(force_n / linear_n, 1.0, 2e-3);
}

TEST(StrainContact, RestsWhereItIsHeld) {
  const StiffScene scene;
  const FemNeedleModel model = scene.Model();
  FemNeedleState state = model.NewState();
  const double before_n = Press(model, state, 14.0, 100).force_in_ct_n.z();
  ASSERT_EQ(state.phase, NeedlePhase::kInside);
  double largest = 0.0;
  for (int n = 0; n < 500; ++n) {
    const double now_n = model.Step(state, AtDepth(state.time_s + 1e-3, 14.0)).force_in_ct_n.z();
    largest = std::max(largest, std::abs(now_n - before_n));
  }
  EXPECT_LT(largest, 1e-6);
}

TEST(StrainContact, ACopyContinuesWithTheSameBits) {
  StiffScene scene;
  scene.settings.iterations = 3;
  const FemNeedleModel model = scene.Model();
  FemNeedleState state = model.NewState();
  Press(model, state, 8.0);
  FemNeedleState copy = state;
  double time_s = state.time_s;
  for (int n = 0; n < 300; ++n) {
    const ToolSample sample = AtDepth(time_s += 1e-3, 8.0 + 0.03 * n, 0.3 + 0.002 * n);
    const forces::NeedleForce a = model.Step(state, sample);
    const forces::NeedleForce b = model.Step(copy, sample);
    ASSERT_EQ(std::memcmp(a.force_in_ct_n.data(), b.force_in_ct_n.data(), 24), 0) << n;
  }
}

TEST(StrainContact, WithdrawnToolsLeaveNothing) {
  const StiffScene scene;
  const FemNeedleModel model = scene.Model();
  FemNeedleState state = model.NewState();
  Press(model, state, 14.0);
  double time_s = state.time_s;
  for (double d = 14.0; d > -3.0; d -= 0.1) model.Step(state, AtDepth(time_s += 1e-3, d));
  EXPECT_EQ(state.phase, NeedlePhase::kFree);
  for (int node = 0; node < model.strain()->region().num_nodes(); ++node) {
    EXPECT_EQ(model.strain()->ForceN(state.strain, node), Eigen::Vector3d::Zero());
  }
}

TEST(StrainContact, RefusesWhatItCannotUse) {
  StiffScene scene;
  scene.settings.max_nodes = 2;
  EXPECT_THAT([&] { scene.Model(); },
              ThrowsMessage<InputError>(HasSubstr("4 to 400 nodes, got 2")));
  scene.settings.max_nodes = 40;
  scene.settings.iterations = 0;
  EXPECT_THAT([&] { scene.Model(); }, ThrowsMessage<InputError>(HasSubstr("1 to 50, got 0")));
  scene.settings.iterations = 3;
  scene.settings.corridor = {{500, 0, 45}, {500, 0, 0}, 10.0};
  EXPECT_THAT([&] { scene.Model(); }, ThrowsMessage<InputError>(HasSubstr("wider corridor")));
}

}  // namespace
}  // namespace acus::tissue
