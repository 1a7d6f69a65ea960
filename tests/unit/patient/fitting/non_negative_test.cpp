#include "acus/patient/fitting/non_negative.h"

#include <Eigen/Dense>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/random.h"

namespace acus::fitting {
namespace {

constexpr int kUnknowns = 6;

struct NormalProblem {
  Eigen::MatrixXd normal;
  Eigen::VectorXd right;
  double Objective(const Eigen::VectorXd& x) const {
    return 0.5 * x.dot(normal * x) - right.dot(x);
  }
};

/// Columns that are much alike, so that one that is negative at first may be positive in the end.
NormalProblem RandomProblem(std::uint64_t seed) {
  RandomStream random(seed, "problem");
  Eigen::MatrixXd columns(8, kUnknowns);
  for (double& value : columns.reshaped()) value = 0.7 + random.Normal();
  Eigen::VectorXd data(8);
  for (double& value : data) value = 0.5 + random.Normal();
  return {columns.transpose() * columns, columns.transpose() * data};
}

/// The least objective of all sets of free unknowns whose minimum is not negative.
double LeastByTrial(const NormalProblem& p) {
  double least = 0.0;
  for (int set = 1; set < 1 << kUnknowns; ++set) {
    std::vector<Eigen::Index> free;
    for (int k = 0; k < kUnknowns; ++k) {
      if ((set >> k & 1) != 0) free.push_back(k);
    }
    Eigen::VectorXd x = Eigen::VectorXd::Zero(kUnknowns);
    const Eigen::VectorXd right = p.right(free);
    x(free) = p.normal(free, free).ldlt().solve(right).eval();
    if (x.minCoeff() >= 0.0) least = std::min(least, p.Objective(x));
  }
  return least;
}

TEST(SolveNonNegative, FindsTheLeastOfAllSets) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const NormalProblem p = RandomProblem(seed);
    const NonNegativeSolution solution = SolveNonNegative(p.normal, p.right);
    const double least = LeastByTrial(p);
    EXPECT_NEAR(p.Objective(solution.x), least, 1e-9 * (1.0 + std::abs(least))) << seed;
    const Eigen::VectorXd slope = p.normal * solution.x - p.right;
    for (int k = 0; k < kUnknowns; ++k) {
      EXPECT_GE(solution.x(k), 0.0) << seed;
      if (solution.is_free[static_cast<std::size_t>(k)]) {
        EXPECT_NEAR(slope(k), 0.0, 1e-9) << seed;
      } else {
        EXPECT_EQ(solution.x(k), 0.0) << seed;
        EXPECT_GE(slope(k), -1e-9) << seed;
      }
    }
  }
}

TEST(SolveNonNegative, WithoutBoundsInTheWayIsThePlainSolution) {
  NormalProblem p = RandomProblem(1);
  const Eigen::VectorXd wanted = Eigen::VectorXd::LinSpaced(kUnknowns, 0.5, 3.0);
  p.right = p.normal * wanted;
  EXPECT_LT((SolveNonNegative(p.normal, p.right).x - wanted).norm(), 1e-9);
}

}  // namespace
}  // namespace acus::fitting
