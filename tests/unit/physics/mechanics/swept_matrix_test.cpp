#include "acus/physics/mechanics/sparse/swept_matrix.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <vector>

#include "acus/base/core/random.h"

namespace acus::mechanics {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd SomeCompliance(int size, std::uint64_t seed) {
  RandomStream random(seed, "compliance");
  MatrixXd m(size, size);
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < size; ++j) m(i, j) = random.Normal();
  }
  return m * m.transpose() / size + 0.1 * MatrixXd::Identity(size, size);
}

/// x for y by a new factorisation: the forces of D follow from C_DD f_D = u_D - C_DS f_S.
VectorXd FreshSolve(const MatrixXd& c, const std::set<int>& displaced, const VectorXd& y) {
  const std::vector<int> d(displaced.begin(), displaced.end());
  VectorXd force = y;
  for (const int i : d) force[i] = 0.0;
  const VectorXd free = c * force;
  if (!d.empty()) {
    const MatrixXd c_dd = c(d, d);
    const VectorXd f_d = c_dd.llt().solve(y(d) - free(d));
    for (std::size_t i = 0; i < d.size(); ++i) force[d[i]] = f_d[i];
  }
  VectorXd x = c * force;
  for (const int i : d) x[i] = force[i];
  return x;
}

VectorXd Solve(const SweptMatrix& swept, const VectorXd& y) {
  VectorXd x(swept.size());
  swept.Solve(y.data(), x.data());
  return x;
}

VectorXd SomeGiven(int size) {
  VectorXd y(size);
  for (int i = 0; i < size; ++i) y[i] = std::sin(1.0 + 3.0 * i);
  return y;
}

TEST(SweptMatrix, IsAFreshSolveAfterAnySwaps) {
  const int size = 24;
  const MatrixXd c = SomeCompliance(size, 1);
  const VectorXd y = SomeGiven(size);
  SweptMatrix swept = SweptMatrix::Of(c);
  std::set<int> displaced;
  RandomStream random(2, "swaps");
  for (int n = 0; n < 300; ++n) {
    const int k = static_cast<int>(random.Uniform(0, size));
    ASSERT_TRUE(swept.Swap(k));
    if (!displaced.erase(k)) displaced.insert(k);
    EXPECT_EQ(swept.IsDisplacement(k), displaced.contains(k));
    const VectorXd want = FreshSolve(c, displaced, y);
    ASSERT_LT((Solve(swept, y) - want).norm(), 1e-12 * (1.0 + want.norm())) << n;
    for (const int i : {0, 7, size - 1}) {
      EXPECT_NEAR(swept.SolveOne(y.data(), i), want[i], 1e-12 * (1.0 + want.norm()));
    }
    VectorXd first(5);
    swept.Solve(y.data(), first.data(), 5);
    EXPECT_LT((first - want.head(5)).norm(), 1e-12 * (1.0 + want.norm()));
  }
}

// The restricted update: what is appended later is as if it had been there all the time.
TEST(SweptMatrix, AppendedOnesAreAsIfTheyHadAlwaysBeenThere) {
  const int size = 20;
  const MatrixXd c = SomeCompliance(size, 3);
  const VectorXd y = SomeGiven(size);
  SweptMatrix full = SweptMatrix::Of(c);
  SweptMatrix restricted(size);
  RandomStream random(4, "swaps");
  std::vector<char> is_displaced(size, 0);
  for (int n = 0; n < 400; ++n) {
    const int in_contact = restricted.size();
    const double what = random.Uniform();
    if (in_contact < size && what < 0.3) {
      const VectorXd row = c.row(in_contact).head(in_contact + 1);
      restricted.Append(row.data());
    } else if (in_contact > 0 && what < 0.5) {
      if (restricted.IsDisplacement(in_contact - 1)) {
        ASSERT_TRUE(restricted.Swap(in_contact - 1));
        ASSERT_TRUE(full.Swap(in_contact - 1));
      }
      restricted.DropLast();
    } else if (in_contact > 0) {
      const int k = static_cast<int>(random.Uniform(0, in_contact));
      ASSERT_TRUE(restricted.Swap(k));
      ASSERT_TRUE(full.Swap(k));
    }
    for (int i = 0; i < restricted.size(); ++i) {
      for (int j = 0; j < restricted.size(); ++j) {
        ASSERT_NEAR(restricted.At(i, j), full.At(i, j), 1e-11);
      }
    }
  }
  EXPECT_GT(restricted.size(), 0);
}

TEST(SweptMatrix, RebuildRemovesWhatSwapsLeft) {
  const int size = 16;
  const MatrixXd c = SomeCompliance(size, 5);
  SweptMatrix worn = SweptMatrix::Of(c);
  SweptMatrix fresh = SweptMatrix::Of(c);
  for (int n = 0; n < 20000; ++n) ASSERT_TRUE(worn.Swap((n * 7) % size));
  ASSERT_TRUE(worn.Swap(3) && worn.Swap(11));
  ASSERT_TRUE(fresh.Swap(3) && fresh.Swap(11));
  const Eigen::Matrix<double, -1, -1, Eigen::RowMajor> rows = c;
  ASSERT_TRUE(worn.Rebuild(rows.data(), size));
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < size; ++j) EXPECT_EQ(worn.At(i, j), fresh.At(i, j));
  }
}

TEST(SweptMatrix, TurnsAPairToOtherAxes) {
  const int size = 10;
  const MatrixXd c = SomeCompliance(size, 6);
  const double angle = 0.7;
  MatrixXd turn = MatrixXd::Identity(size, size);
  turn.block<2, 2>(4, 4) << std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle);
  SweptMatrix turned = SweptMatrix::Of(c);
  turned.Rotate(4, std::cos(angle), std::sin(angle));
  const MatrixXd want = turn * c * turn.transpose();
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < size; ++j) EXPECT_NEAR(turned.At(i, j), want(i, j), 1e-14);
  }
}

TEST(SweptMatrix, RefusesAPivotThatIsNoCompliance) {
  MatrixXd c = MatrixXd::Identity(3, 3);
  c(1, 1) = 0.0;
  SweptMatrix swept = SweptMatrix::Of(c);
  EXPECT_FALSE(swept.Swap(1));
  EXPECT_FALSE(swept.IsDisplacement(1));
  c(1, 1) = std::nan("");
  SweptMatrix broken = SweptMatrix::Of(c);
  EXPECT_FALSE(broken.Swap(1));
  EXPECT_TRUE(broken.Swap(0));
}

}  // namespace
}  // namespace acus::mechanics
