#include "acus/physics/tissue/plane_contact.h"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "acus/base/core/random.h"

namespace acus::tissue {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd SomeCompliance(int size) {
  RandomStream random(1, "compliance");
  MatrixXd m(size, size);
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < size; ++j) m(i, j) = random.Normal();
  }
  return m * m.transpose() / size + 0.05 * MatrixXd::Identity(size, size);
}

struct Demand {
  double target_mm, low_n, high_n;
};

/// The same problem by projected Gauss-Seidel: slow, and wrong in no way.
VectorXd Reference(const MatrixXd& c, const std::vector<Demand>& demand) {
  VectorXd force = VectorXd::Zero(c.rows());
  for (int round = 0; round < 200000; ++round) {
    double change = 0.0;
    for (int i = 0; i < c.rows(); ++i) {
      const double miss = demand[i].target_mm - c.row(i).dot(force);
      const double now = std::clamp(force[i] + miss / c(i, i), demand[i].low_n, demand[i].high_n);
      change = std::max(change, std::abs(now - force[i]));
      force[i] = now;
    }
    if (change < 1e-15) break;
  }
  return force;
}

/// Compliance between the directions of the slots.
MatrixXd Turned(const MatrixXd& c, const std::vector<int>& dofs, double cosine, double sine) {
  MatrixXd turn = MatrixXd::Zero(2 * dofs.size(), c.rows());
  for (std::size_t p = 0; p < dofs.size(); ++p) {
    turn(2 * p, dofs[p]) = turn(2 * p + 1, dofs[p] + 1) = cosine;
    turn(2 * p, dofs[p] + 1) = sine;
    turn(2 * p + 1, dofs[p]) = -sine;
  }
  return turn * c * turn.transpose();
}

class PlaneContactTest : public testing::TestWithParam<PlaneUpdate> {};

TEST_P(PlaneContactTest, FindsTheForcesOfTheBoundedProblem) {
  const MatrixXd c = SomeCompliance(40);
  const std::vector<int> dofs = {6, 22, 0, 36, 14, 30};
  const double angle = 0.4;
  PlaneContact contact(c, 16, GetParam());
  for (const int dof : dofs) contact.Append(dof, std::cos(angle), std::sin(angle));
  const MatrixXd turned = Turned(c, dofs, std::cos(angle), std::sin(angle));
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < 12; ++j) EXPECT_NEAR(contact.Compliance(i, j), turned(i, j), 1e-14);
  }
  RandomStream random(2, "demands");
  int sticking = 0;
  int slipping = 0;
  for (int n = 0; n < 200; ++n) {
    std::vector<Demand> demand(12);
    for (int i = 0; i < 12; ++i) {
      const double bound_n = i % 5 == 4 ? 0.0 : random.Uniform(0, 2);
      demand[i] = {random.Uniform(-1, 1), -bound_n, i % 2 == 0 ? bound_n : 3 * bound_n};
      contact.SetDemand(i, demand[i].target_mm, demand[i].low_n, demand[i].high_n);
    }
    ASSERT_TRUE(contact.Solve(1e-10));
    const VectorXd want = Reference(turned, demand);
    const VectorXd moved = turned * want;
    for (int i = 0; i < 12; ++i) {
      ASSERT_NEAR(contact.ForceN(i), want[i], 1e-9) << n << " " << i;
      ASSERT_NEAR(contact.DisplacementMm(i), moved[i], 1e-9) << n << " " << i;
      (contact.Status(i) == SlotStatus::kStick ? sticking : slipping) += 1;
    }
  }
  EXPECT_GT(sticking, 200);
  EXPECT_GT(slipping, 200);
  EXPECT_EQ(contact.num_unresolved(), 0);
  EXPECT_EQ(contact.num_rebuilds(), 0);
}

TEST_P(PlaneContactTest, NodesComeWhereTheyAreAndLeaveWithoutATrace) {
  const MatrixXd c = SomeCompliance(20);
  PlaneContact contact(c, 8, GetParam());
  contact.Append(4, 1.0, 0.0);
  contact.SetDemand(0, 0.7, -1.0, 1.0);
  contact.SetDemand(1, -0.2, -1.0, 1.0);
  ASSERT_TRUE(contact.Solve(1e-10));
  const double force_n = contact.ForceN(0);
  contact.Append(10, 0.6, 0.8);
  const double u = c(10, 4) * contact.ForceN(0) + c(10, 5) * contact.ForceN(1);
  const double v = c(11, 4) * contact.ForceN(0) + c(11, 5) * contact.ForceN(1);
  EXPECT_NEAR(contact.DisplacementMm(2), 0.6 * u + 0.8 * v, 1e-13);
  EXPECT_NEAR(contact.DisplacementMm(3), -0.8 * u + 0.6 * v, 1e-13);
  contact.SetDemand(2, 2.0, -5.0, 5.0);
  contact.SetDemand(3, 2.0, -5.0, 5.0);
  ASSERT_TRUE(contact.Solve(1e-10));
  EXPECT_GT(std::abs(contact.ForceN(0) - force_n), 1e-3);
  contact.DropLast();
  ASSERT_TRUE(contact.Solve(1e-10));
  EXPECT_NEAR(contact.ForceN(0), force_n, 1e-12);
  contact.Clear();
  EXPECT_EQ(contact.size(), 0);
  contact.Append(4, 1.0, 0.0);
  EXPECT_EQ(contact.DisplacementMm(0), 0.0);
}

TEST_P(PlaneContactTest, TheMonitorStartsAgainAndCountsIt) {
  const MatrixXd c = SomeCompliance(20);
  PlaneContact contact(c, 8, GetParam());
  PlaneContact whole(c, 8, GetParam());
  for (PlaneContact* one : {&contact, &whole}) {
    one->Append(4, 0.8, 0.6);
    one->Append(12, 0.8, 0.6);
    for (int i = 0; i < 4; ++i) one->SetDemand(i, 0.3 + 0.1 * i, -0.4, 9.0);
  }
  contact.SpoilForTest(1.0 + 1e-6);
  ASSERT_TRUE(contact.Solve(1e-10));
  ASSERT_TRUE(whole.Solve(1e-10));
  EXPECT_EQ(contact.num_rebuilds(), 1);
  EXPECT_EQ(whole.num_rebuilds(), 0);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(contact.ForceN(i), whole.ForceN(i), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Updates, PlaneContactTest,
                         testing::Values(PlaneUpdate::kRestricted, PlaneUpdate::kFull),
                         [](const auto& update) {
                           return update.param == PlaneUpdate::kFull ? "Full" : "Restricted";
                         });

}  // namespace
}  // namespace acus::tissue
