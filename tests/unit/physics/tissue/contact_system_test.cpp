#include "acus/physics/tissue/contact_system.h"

#include <gtest/gtest.h>
#include <numbers>

#include "acus/base/core/random.h"
#include "acus/physics/tissue/contact_mesh.h"
#include "support/elastic_box.h"
#include "support/fresh_contact.h"

namespace acus::tissue {
namespace {

using testing_support::BoxMesh;
using testing_support::CompareWithFresh;
using testing_support::FreshComparison;

/// 40 mm of soft tissue, held at the bottom, all nodes in reach.
struct Block {
  mesh::TetraMesh mesh = [] {
    mesh::TetraMesh box = BoxMesh({4, 4, 4}, {-20, -20, 0}, {20, 20, 40}, 0.1);
    testing_support::Fix(box, [](const Eigen::Vector3d& x) { return x.z() < 0.1; });
    return box;
  }();
  mechanics::Compliance compliance = testing_support::ComplianceOf(
      mesh, testing_support::ElasticLabels({{4, {0.01, 0.45}}}), mechanics::Storage::kDouble,
      [](const Eigen::Vector3d&) { return true; });
  ContactMesh places{mesh, compliance};
};
const Block& TheBlock() {
  static const Block block;
  return block;
}

Eigen::Vector3d OnPath(double depth_mm) {
  return Eigen::Vector3d(1.3, -2.1, 39.9) +
         depth_mm * Eigen::Vector3d(0.1, 0.05, -0.9).normalized();
}

Eigen::Matrix3d PathFrame() {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.1, 0.05, -0.9).normalized();
  Eigen::Matrix3d frame;
  frame << axis.unitOrthogonal(), axis.cross(axis.unitOrthogonal()), axis;
  return frame;
}

constexpr LocalCompliance kLocal{2.0, 3.0};

void AskForSomething(ContactState& state, RandomStream& random) {
  for (int p = 0; p < state.num_points(); ++p) {
    state.SetLateral(p, random.Uniform(-1, 1), random.Uniform(-1, 1));
    state.SetPointAxial(p, random.Uniform(-2, 2), -0.05, 0.05);
  }
  for (int s = 0; s < state.num_slots(); ++s) {
    state.SetSlotDemand(s, random.Uniform(-1, 1), 0.0, s == 0 ? 0.7 : 1e300);
  }
}

TEST(ContactSystem, OnePointOnAKnownCompliance) {
  // One node of 2 mm/N, in series with what the mesh does not resolve.
  const auto compliance = mechanics::Compliance::FromMatrix({7}, 2.0 * Eigen::Matrix3d::Identity(),
                                                            mechanics::Storage::kDouble);
  const ContactSystem system(compliance, {.points = 4, .slots = 1});
  ContactState state = system.NewState();
  system.Restart(state, Eigen::Matrix3d::Identity());
  const ContactPlace node{{0}, {1.0}, 1};
  EXPECT_EQ(system.AppendPoint(state, node, {1.0, 3.0}), Eigen::Vector3d::Zero());
  state.SetLateral(0, 0.6, -0.3);
  state.SetPointAxial(0, 1.0, -0.5, 0.5);
  ASSERT_TRUE(system.Solve(state));
  EXPECT_TRUE(state.PointForceN(0).isApprox(Eigen::Vector3d(0.2, -0.1, 0.2), 1e-15));
  state.SetPointAxial(0, 10.0, -0.5, 0.5);  // More than friction can pull along.
  ASSERT_TRUE(system.Solve(state));
  EXPECT_EQ(state.PointForceN(0)[2], 0.5);
  EXPECT_EQ(state.PointStatus(0), ContactStatus::kAtHigh);
  EXPECT_NEAR(state.PointExcessMm(0), 0.5 * 5.0 - 10.0, 1e-15);
  EXPECT_NEAR(system.ResidualMm(state, 0), 0.0, 1e-15);
}

TEST(ContactSystem, TheLoopOfAPointDrivenToAndFroIsItsFrictionWork) {
  // Elastic and dry friction in series: driven by +-A, it slips 2 (A - f c) each way at force f.
  constexpr double kFrictionN = 0.2;
  constexpr double kCompliance = 5.0;
  constexpr double kAmplitudeMm = 3.0;
  const auto compliance = mechanics::Compliance::FromMatrix({0}, 2.0 * Eigen::Matrix3d::Identity(),
                                                            mechanics::Storage::kDouble);
  const ContactSystem system(compliance, {.points = 1, .slots = 0});
  ContactState state = system.NewState();
  system.Restart(state, Eigen::Matrix3d::Identity());
  system.AppendPoint(state, ContactPlace{{0}, {1.0}, 1}, {1.0, kCompliance - 2.0});
  double slip_mm = 0.0;
  double work_n_mm = 0.0;
  double last_mm = 0.0;
  double last_n = 0.0;
  state.SetLateral(0, 0.0, 0.0);
  constexpr int kSteps = 4000;
  for (int step = 1; step <= 3 * kSteps; ++step) {
    const double at_mm = kAmplitudeMm * std::sin(2.0 * std::numbers::pi * step / kSteps);
    state.SetPointAxial(0, at_mm - slip_mm, -kFrictionN, kFrictionN);
    system.Solve(state);
    slip_mm -= state.PointExcessMm(0);
    const double force_n = state.PointForceN(0)[2];
    if (step > 2 * kSteps) work_n_mm += 0.5 * (force_n + last_n) * (at_mm - last_mm);
    last_mm = at_mm;
    last_n = force_n;
  }
  const double slip_each_way_mm = 2.0 * (kAmplitudeMm - kFrictionN * kCompliance);
  EXPECT_NEAR(work_n_mm, 2.0 * kFrictionN * slip_each_way_mm, 1e-5);
}

TEST(ContactSystem, PointsInASymmetricLayoutFeelSymmetricForces) {
  mesh::TetraMesh box = BoxMesh({4, 4, 4}, {-20, -20, 0}, {20, 20, 40});
  testing_support::Fix(box, [](const Eigen::Vector3d& x) { return x.z() < 0.1 || x.z() > 39.9; });
  // The six tetrahedra of a cell are the same seen from the opposite corner.
  const auto compliance = testing_support::ComplianceOf(
      box, testing_support::ElasticLabels({{4, {0.01, 0.45}}}), mechanics::Storage::kDouble,
      [](const Eigen::Vector3d&) { return true; });
  const ContactMesh places(box, compliance);
  const ContactSystem system(compliance, {.points = 10, .slots = 0});
  ContactState state = system.NewState();
  system.Restart(state, Eigen::Matrix3d::Identity());
  for (int p = 0; p < 10; ++p) {
    system.AppendPoint(state, places.Find({0.0, 0.0, 2.0 + 4.0 * p}).place, kLocal);
    state.SetLateral(p, 0.4, 0.1);
    state.SetPointAxial(p, 0.3, -0.02, 0.02);
  }
  system.Solve(state);
  for (int p = 0; p < 5; ++p) {
    EXPECT_LT((state.PointForceN(p) - state.PointForceN(9 - p)).norm(), 1e-12) << p;
  }
}

TEST(ContactSystem, SolvesWhatADenseSolveGivesOverRandomHistories) {
  const Block& block = TheBlock();
  const ContactSystem system(block.compliance, {.points = 30, .slots = 5});
  ContactState state = system.NewState();
  system.Restart(state, PathFrame());
  RandomStream random(3, "history");
  double worst_n = 0.0;
  for (int step = 0; step < 1500; ++step) {
    const double action = random.Uniform();
    if (action < 0.4 && state.num_points() < 30) {
      system.AppendPoint(state, block.places.Find(OnPath(1.2 * state.num_points())).place, kLocal);
    } else if (action < 0.55) {
      system.TruncatePoints(state, static_cast<int>(random.Uniform() * (state.num_points() + 1)));
    } else if (action < 0.8) {
      const int slot = static_cast<int>(5 * random.Uniform());
      const Eigen::Vector3d direction =
          Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
      system.SetSlot(state, slot, block.places.Find(OnPath(random.Uniform(0, 38))).place, direction,
                     0.5);
    } else if (action < 0.85) {
      system.ClearSlot(state, static_cast<int>(5 * random.Uniform()));
    }
    AskForSomething(state, random);
    ASSERT_TRUE(system.Solve(state));
    if (step % 5 != 0) continue;
    const FreshComparison fresh = CompareWithFresh(system, state);
    ASSERT_LT(fresh.breach, 1e-10) << step;
    worst_n = std::max(worst_n, fresh.force_error_n);
  }
  EXPECT_LT(worst_n, 1e-11);
  EXPECT_EQ(state.num_refactors(), 0);
  EXPECT_GT(state.num_checks(), 50);
}

TEST(ContactSystem, HasNoMemoryOfWhatWasAppendedAndDropped) {
  const Block& block = TheBlock();
  const ContactSystem system(block.compliance, {.points = 30, .slots = 4});
  RandomStream random(4, "history");
  const auto append = [&](ContactState& state, int end, double spacing_mm) {
    while (state.num_points() < end) {
      const double depth_mm = spacing_mm * state.num_points();
      system.AppendPoint(state, block.places.Find(OnPath(depth_mm)).place, kLocal);
    }
  };
  const auto set_slot = [&](ContactState& state, int slot, double depth_mm) {
    system.SetSlot(state, slot, block.places.Find(OnPath(depth_mm)).place,
                   Eigen::Vector3d(0.6, 0.0, -0.8), 0.5);
  };
  ContactState worn = system.NewState();
  system.Restart(worn, PathFrame());
  set_slot(worn, 1, 30.0);
  for (int n = 0; n < 200; ++n) {
    append(worn, 1 + static_cast<int>(30 * random.Uniform()), 1.3);
    set_slot(worn, static_cast<int>(4 * random.Uniform()), random.Uniform(0, 38));
    AskForSomething(worn, random);
    system.Solve(worn);
    system.TruncatePoints(worn, static_cast<int>(worn.num_points() * random.Uniform()));
  }
  for (const int end : {3, 8, 13, 21, 30}) {
    system.TruncatePoints(worn, std::min(worn.num_points(), end > 8 ? 5 : 2));
    append(worn, end, 1.3);
    for (int s = 0; s < 3; ++s) set_slot(worn, s, 11.0 * s);
    system.ClearSlot(worn, 3);

    ContactState fresh = system.NewState();
    system.Restart(fresh, PathFrame());
    for (int s = 0; s < 3; ++s) set_slot(fresh, s, 11.0 * s);
    append(fresh, end, 1.3);

    RandomStream demand(5, "demand");
    AskForSomething(worn, demand);
    demand = RandomStream(5, "demand");
    AskForSomething(fresh, demand);
    for (int column = 0; column < 4 + end; ++column) {
      fresh.CopyStatusForTest(column, worn.Status(column));
    }
    system.Solve(worn);
    system.Solve(fresh);
    for (int p = 0; p < end; ++p) ASSERT_EQ(worn.PointForceN(p), fresh.PointForceN(p)) << p;
    for (int s = 0; s < 4; ++s) ASSERT_EQ(worn.SlotForceN(s), fresh.SlotForceN(s)) << s;
  }
}

TEST(ContactSystem, ANewPointIsFreeOfForceAndKnowsItsDisplacement) {
  const Block& block = TheBlock();
  const ContactSystem system(block.compliance, {.points = 12, .slots = 1});
  ContactState state = system.NewState();
  system.Restart(state, PathFrame());
  RandomStream random(6, "demand");
  system.SetSlot(state, 0, block.places.Find(OnPath(20)).place, PathFrame().col(2), 1.0);
  for (int p = 0; p < 10; ++p) {
    const ContactPlace place = block.places.Find(OnPath(2.0 * p)).place;
    const Eigen::Vector3d before = system.DisplacementMm(state, place);
    const Eigen::Vector3d moved = system.AppendPoint(state, place, kLocal);
    EXPECT_LT((state.frame() * moved - before).norm(), 1e-12);
    EXPECT_EQ(state.PointForceN(p), Eigen::Vector3d::Zero());
    AskForSomething(state, random);
    system.Solve(state);
  }
}

TEST(ContactSystem, DetectsADamagedFactorRepairsAndCountsIt) {
  const Block& block = TheBlock();
  const ContactSystem system(block.compliance, {.points = 10, .slots = 1});
  ContactState state = system.NewState();
  system.Restart(state, PathFrame());
  for (int p = 0; p < 10; ++p) {
    system.AppendPoint(state, block.places.Find(OnPath(2.0 * p)).place, kLocal);
  }
  RandomStream random(7, "demand");
  state.SpoilFactorForTest(1.0 + 1e-6);
  int solves = 0;
  for (; solves < 1000 && state.num_refactors() == 0; ++solves) {
    AskForSomething(state, random);
    system.Solve(state);
  }
  EXPECT_EQ(state.num_refactors(), 1);
  EXPECT_LE(solves, 16);
  const FreshComparison fresh = CompareWithFresh(system, state);
  EXPECT_LT(fresh.force_error_n, 1e-12);
}

TEST(ContactSystem, FloatStorageIsSolvedInDouble) {
  const Block& block = TheBlock();
  const int size = 3 * block.compliance.num_nodes();
  Eigen::MatrixXd matrix(size, size);
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < size; ++j) matrix(i, j) = block.compliance.At(i, j);
  }
  const std::vector<int> nodes(block.compliance.nodes().begin(), block.compliance.nodes().end());
  const auto rounded = mechanics::Compliance::FromMatrix(nodes, matrix, mechanics::Storage::kFloat);
  const ContactSystem system(rounded, {.points = 20, .slots = 1});
  ContactState state = system.NewState();
  system.Restart(state, PathFrame());
  for (int p = 0; p < 20; ++p) {
    system.AppendPoint(state, block.places.Find(OnPath(1.5 * p)).place, kLocal);
  }
  RandomStream random(8, "demand");
  AskForSomething(state, random);
  ASSERT_TRUE(system.Solve(state));
  EXPECT_LT(CompareWithFresh(system, state).force_error_n, 1e-13);
}

}  // namespace
}  // namespace acus::tissue
