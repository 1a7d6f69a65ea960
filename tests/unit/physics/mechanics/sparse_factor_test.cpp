#include "acus/physics/mechanics/sparse/sparse_factor.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::mechanics {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// A grid of springs of random stiffness between random pairs of rows and to the ground.
Eigen::MatrixXd Springs(int size) {
  RandomStream random(3, "springs");
  Eigen::MatrixXd k = 0.01 * Eigen::MatrixXd::Identity(size, size);
  for (int n = 0; n < 4 * size; ++n) {
    const int i = static_cast<int>(random.Uniform(0, size));
    const int j = static_cast<int>(random.Uniform(0, size));
    const double stiffness = random.Uniform(0.1, 1.0);
    if (i == j) continue;
    k(i, i) += stiffness;
    k(j, j) += stiffness;
    k(i, j) -= stiffness;
    k(j, i) -= stiffness;
  }
  return k;
}

Eigen::SparseMatrix<double> LowerOf(const Eigen::MatrixXd& dense) {
  return Eigen::MatrixXd(dense.triangularView<Eigen::Lower>()).sparseView();
}

TEST(SparseFactor, SolvesWithManyRightSides) {
  const Eigen::MatrixXd k = Springs(90);
  for (const int block : {1, 3}) {
    SparseFactor factor(LowerOf(k), block);
    EXPECT_EQ(factor.num_rows(), 90);
    const Eigen::MatrixXd inverse = factor.Solve(Eigen::MatrixXd::Identity(90, 90));
    EXPECT_LT((k * inverse - Eigen::MatrixXd::Identity(90, 90)).norm(), 1e-11);
    factor.Refactor(LowerOf(4.0 * k));
    EXPECT_LT((4.0 * factor.Solve(Eigen::MatrixXd::Identity(90, 90)) - inverse).norm(), 1e-9);
    EXPECT_GE(factor.num_values(), 90.0);
  }
}

TEST(SparseFactor, TheSameMatrixGivesTheSameBits) {
  const Eigen::MatrixXd k = Springs(300);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(300, -1.0, 2.0);
  const Eigen::VectorXd first = SparseFactor(LowerOf(k)).Solve(b);
  EXPECT_EQ(first, SparseFactor(LowerOf(k)).Solve(b));
}

TEST(SparseFactor, CanBeMoved) {
  SparseFactor factor(LowerOf(2.0 * Eigen::MatrixXd::Identity(6, 6)));
  SparseFactor other = std::move(factor);
  EXPECT_TRUE(other.Solve(Eigen::VectorXd::Ones(6)).isApproxToConstant(0.5, 1e-15));
}

TEST(SparseFactor, AMatrixThatIsNotPositiveDefiniteIsReportedWithItsRow) {
  Eigen::MatrixXd k = Eigen::MatrixXd::Identity(9, 9);
  k(4, 4) = -1.0;
  EXPECT_THAT([&] { SparseFactor{LowerOf(k)}; },
              ThrowsMessage<NoAnswerError>(HasSubstr("not positive definite at row 4")));
  SparseFactor factor(LowerOf(Eigen::MatrixXd::Identity(9, 9)));
  EXPECT_THROW(factor.Refactor(LowerOf(k)), NoAnswerError);
  EXPECT_FALSE(factor.TryRefactor(LowerOf(k)));
  // And is of use again.
  EXPECT_TRUE(factor.TryRefactor(LowerOf(2.0 * Eigen::MatrixXd::Identity(9, 9))));
  EXPECT_TRUE(factor.Solve(Eigen::VectorXd::Ones(9)).isApproxToConstant(0.5, 1e-15));
}

}  // namespace
}  // namespace acus::mechanics
