#include "acus/physics/mechanics/condensation/compliance.h"

#include <gtest/gtest.h>

namespace acus::mechanics {
namespace {

Eigen::MatrixXd SomeMatrix(int size) {
  Eigen::MatrixXd m(size, size);
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < size; ++j) m(i, j) = 1.0 / (1 + i + j) + 0.1 * std::abs(i - j);
  }
  return m;
}

TEST(Compliance, KeepsDoublesExactlyAndFloatsRounded) {
  const Eigen::MatrixXd m = SomeMatrix(6);
  const auto exact = Compliance::FromMatrix({4, 9}, m, Storage::kDouble);
  const auto rounded = Compliance::FromMatrix({4, 9}, m, Storage::kFloat);
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      EXPECT_EQ(exact.At(i, j), m(i, j));
      EXPECT_EQ(rounded.At(i, j), static_cast<double>(static_cast<float>(m(i, j))));
      EXPECT_EQ(exact.Values<double>(i)[j], m(i, j));
    }
  }
}

TEST(Compliance, FindsRowsOfMeshNodes) {
  const auto c = Compliance::FromMatrix({4, 9, 17}, SomeMatrix(9), Storage::kFloat);
  EXPECT_EQ(c.RowOf(4), 0);
  EXPECT_EQ(c.RowOf(17), 2);
  EXPECT_EQ(c.RowOf(5), -1);
  EXPECT_EQ(c.RowOf(18), -1);
}

TEST(Compliance, CopiesShareNumbersThatOutliveTheFirst) {
  Compliance copy;
  {
    const auto first = Compliance::FromMatrix({1, 2}, SomeMatrix(6), Storage::kDouble);
    copy = first;
    EXPECT_EQ(copy.Values<double>(0), first.Values<double>(0));
  }
  EXPECT_EQ(copy.At(0, 0), 1.0);
}

TEST(ComplianceDeathTest, RefusesSizesThatDisagree) {
  EXPECT_DEATH(Compliance::FromMatrix({1, 2, 3}, SomeMatrix(6), Storage::kDouble), "");
}

}  // namespace
}  // namespace acus::mechanics
