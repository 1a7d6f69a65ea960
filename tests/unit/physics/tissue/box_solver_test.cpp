#include "acus/physics/tissue/box_solver.h"

#include <Eigen/Dense>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/random.h"

namespace acus::tissue {
namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct Box {
  RowMatrix matrix;
  Eigen::VectorXd rhs, low, high;
  BoxSolver::Problem View() const {
    return {static_cast<int>(rhs.size()),
            matrix.data(),
            matrix.cols(),
            rhs.data(),
            low.data(),
            high.data()};
  }
  double Energy(const Eigen::VectorXd& x) const { return 0.5 * x.dot(matrix * x) - rhs.dot(x); }
};

Box RandomBox(int size, RandomStream& random, double condition = 1.0) {
  Box box;
  Eigen::MatrixXd root(size, size);
  for (double& value : root.reshaped()) value = random.Uniform() - 0.5;
  box.matrix = root * root.transpose();
  box.matrix.diagonal().array() += 0.05 / condition;
  box.rhs = box.low = box.high = Eigen::VectorXd::Zero(size);
  for (int i = 0; i < size; ++i) {
    box.rhs[i] = 4.0 * (random.Uniform() - 0.5);
    box.low[i] = -random.Uniform();
    box.high[i] = random.Uniform();
  }
  return box;
}

BoxSolver AllStick(int size) {
  BoxSolver solver(size);
  for (int i = 0; i < size; ++i) solver.SetStatus(i, ContactStatus::kStick);
  return solver;
}

/// The least energy over all 3^n choices of stick, low and high that keep to the bounds.
Eigen::VectorXd BestOfAllChoices(const Box& box) {
  const int n = static_cast<int>(box.rhs.size());
  int num_choices = 1;
  for (int i = 0; i < n; ++i) num_choices *= 3;
  Eigen::VectorXd best;
  double least = std::numeric_limits<double>::infinity();
  for (int choice = 0; choice < num_choices; ++choice) {
    Eigen::VectorXd x(n);
    std::vector<int> free;
    for (int i = 0, rest = choice; i < n; ++i, rest /= 3) {
      x[i] = rest % 3 == 0 ? 0.0 : (rest % 3 == 1 ? box.low[i] : box.high[i]);
      if (rest % 3 == 0) free.push_back(i);
    }
    if (!free.empty()) {
      const Eigen::VectorXd left = box.rhs - box.matrix * x;
      const Eigen::MatrixXd part = box.matrix(free, free);
      const Eigen::VectorXd some = part.ldlt().solve(Eigen::VectorXd(left(free)));
      x(free) = some;
    }
    const bool within =
        ((x - box.low).array() > -1e-12).all() && ((box.high - x).array() > -1e-12).all();
    if (within && box.Energy(x) < least) {
      least = box.Energy(x);
      best = x;
    }
  }
  return best;
}

TEST(BoxSolver, FindsTheBestOfAllChoicesOfStickAndSlip) {
  RandomStream random(11, "box");
  for (int n = 1; n <= 6; ++n) {
    for (int trial = 0; trial < 40; ++trial) {
      const Box box = RandomBox(n, random);
      BoxSolver solver = AllStick(n);
      Eigen::VectorXd x(n);
      ASSERT_TRUE(solver.Solve(box.View(), x.data()));
      EXPECT_LT((x - BestOfAllChoices(box)).cwiseAbs().maxCoeff(), 1e-10) << n << " " << trial;
    }
  }
}

TEST(BoxSolver, SatisfiesTheConditionsOfTheMinimumFromAnyStart) {
  RandomStream random(12, "box");
  BoxSolver solver = AllStick(60);
  for (int trial = 0; trial < 300; ++trial) {
    // Statuses of the last problem have nothing to do with this one.
    const Box box = RandomBox(60, random, trial % 3 == 0 ? 1e5 : 1.0);
    solver.Forget(0);
    Eigen::VectorXd x(60);
    ASSERT_TRUE(solver.Solve(box.View(), x.data()));
    const Eigen::VectorXd excess = box.matrix * x - box.rhs;
    for (int i = 0; i < 60; ++i) {
      ASSERT_GE(x[i], box.low[i]);
      ASSERT_LE(x[i], box.high[i]);
      EXPECT_NEAR(solver.Excess(i), excess[i], 1e-11);
      if (x[i] > box.low[i] + 1e-9) {
        EXPECT_LT(excess[i], 1e-9);
      }
      if (x[i] < box.high[i] - 1e-9) {
        EXPECT_GT(excess[i], -1e-9);
      }
    }
  }
  EXPECT_EQ(solver.counts().num_fallbacks, 0);
}

TEST(BoxSolver, KeepsWhatIsRightOfTheFactorAndTheSameBits) {
  RandomStream random(13, "box");
  Box box = RandomBox(40, random);
  BoxSolver warm = AllStick(40);
  Eigen::VectorXd x(40), y(40);
  for (int trial = 0; trial < 200; ++trial) {
    for (double& value : box.rhs) value += 0.3 * (random.Uniform() - 0.5);
    BoxSolver copy = warm;
    copy.Forget(0);  // The same start, nothing kept.
    ASSERT_TRUE(warm.Solve(box.View(), x.data()));
    ASSERT_TRUE(copy.Solve(box.View(), y.data()));
    ASSERT_EQ(x, y) << trial;
  }
}

TEST(BoxSolver, LeavesOutWhatIsOffAndHoldsWhatHasNoRoom) {
  RandomStream random(14, "box");
  Box box = RandomBox(5, random);
  box.low[2] = box.high[2] = 0.25;
  box.high[3] = std::numeric_limits<double>::infinity();
  box.low[3] = 0.0;
  BoxSolver solver = AllStick(5);
  solver.SetStatus(1, ContactStatus::kOff);
  solver.SetStatus(3, ContactStatus::kAtHigh);  // There is no such bound.
  Eigen::VectorXd x(5);
  ASSERT_TRUE(solver.Solve(box.View(), x.data()));
  EXPECT_EQ(x[1], 0.0);
  EXPECT_EQ(x[2], 0.25);
  EXPECT_TRUE(x.allFinite());
  EXPECT_GE(x[3], 0.0);
}

TEST(BoxSolver, KeepsToTheBoundsWhenNumbersAreInvalid) {
  RandomStream random(15, "box");
  Box box = RandomBox(12, random);
  box.rhs[4] = std::numeric_limits<double>::quiet_NaN();
  BoxSolver solver = AllStick(12);
  Eigen::VectorXd x(12);
  EXPECT_FALSE(solver.Solve(box.View(), x.data()));
  EXPECT_EQ(solver.counts().num_fallbacks, 1);
  for (int i = 0; i < 12; ++i) {
    EXPECT_FALSE(x[i] < box.low[i] || x[i] > box.high[i]);
  }
  // And the next good problem is solved as ever.
  box.rhs[4] = 0.1;
  EXPECT_TRUE(solver.Solve(box.View(), x.data()));
}

}  // namespace
}  // namespace acus::tissue
