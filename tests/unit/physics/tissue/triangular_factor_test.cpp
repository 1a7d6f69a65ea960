#include "acus/physics/tissue/triangular_factor.h"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "acus/base/core/random.h"

namespace acus::tissue {
namespace {

Eigen::MatrixXd RandomPositive(int size, std::uint64_t seed) {
  RandomStream random(seed, "positive");
  Eigen::MatrixXd root(size, size);
  for (double& value : root.reshaped()) value = random.Uniform() - 0.5;
  return root * root.transpose() + 0.1 * Eigen::MatrixXd::Identity(size, size);
}

void AppendColumns(TriangularFactor& factor, const Eigen::MatrixXd& a, int end) {
  for (int j = factor.size(); j < end; ++j) {
    Eigen::VectorXd column = a.col(j).head(j + 1);
    EXPECT_TRUE(factor.Append(column.data()));
  }
}

TEST(TriangularFactor, SolvesWhatItIsOf) {
  const Eigen::MatrixXd a = RandomPositive(45, 1);
  TriangularFactor factor(50);
  AppendColumns(factor, a, 45);
  const Eigen::VectorXd rhs = a * Eigen::VectorXd::LinSpaced(45, -1.0, 1.0);
  Eigen::VectorXd x = rhs;
  factor.SolveLower(x.data());
  const Eigen::MatrixXd u = a.llt().matrixU();
  EXPECT_LT((u.transpose() * x - rhs).norm(), 1e-11);
  factor.SolveUpper(x.data());
  EXPECT_LT((x - Eigen::VectorXd::LinSpaced(45, -1.0, 1.0)).norm(), 1e-10);
}

TEST(TriangularFactor, HasTheSameBitsHoweverItCameAbout) {
  const Eigen::MatrixXd a = RandomPositive(61, 2);
  Eigen::MatrixXd other = a;  // The same in its first 20 columns.
  other.diagonal().tail(41).array() += 1.0;
  TriangularFactor fresh(64), worn(64), blockwise(64);
  AppendColumns(fresh, a, 61);
  RandomStream random(4, "history");
  for (int n = 0; n < 50; ++n) {
    AppendColumns(worn, a, 20);
    const int end = 21 + static_cast<int>(40 * random.Uniform());
    AppendColumns(worn, other, end);
    worn.Truncate(20);
  }
  AppendColumns(worn, a, 61);
  for (const int end : {7, 8, 40, 61}) {
    for (int k = 0; k < end; ++k) {
      for (int j = std::max(k, blockwise.size()); j < end; ++j) blockwise.Row(k)[j] = a(k, j);
    }
    EXPECT_EQ(blockwise.FinishColumns(end - blockwise.size()), 0);
  }
  for (int k = 0; k < 61; ++k) {
    for (int j = k; j < 61; ++j) {
      ASSERT_EQ(fresh.Row(k)[j], worn.Row(k)[j]) << k << " " << j;
      ASSERT_EQ(fresh.Row(k)[j], blockwise.Row(k)[j]) << k << " " << j;
    }
  }
}

TEST(TriangularFactor, RaisesAPivotThatIsNotPositiveAndSaysSo) {
  TriangularFactor factor(2);
  Eigen::VectorXd column(1);
  column << 4.0;
  EXPECT_TRUE(factor.Append(column.data()));
  Eigen::VectorXd twin(2);
  twin << 4.0, 4.0;  // The same unknown twice.
  EXPECT_FALSE(factor.Append(twin.data()));
  EXPECT_GT(factor.Row(1)[1], 0.0);
}

TEST(Dot, AddsEveryElementOnce) {
  for (int n = 0; n < 40; ++n) {
    const Eigen::VectorXd a = Eigen::VectorXd::LinSpaced(n, 1.0, 3.0);
    EXPECT_NEAR(Dot(a.data(), a.data(), n), a.squaredNorm(), 1e-12);
  }
}

}  // namespace
}  // namespace acus::tissue
