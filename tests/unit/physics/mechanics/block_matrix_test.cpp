#include "acus/physics/mechanics/sparse/block_matrix.h"

#include <gtest/gtest.h>

namespace acus::mechanics {
namespace {

Eigen::MatrixXd Symmetric(int size, double first) {
  Eigen::MatrixXd m(size, size);
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < size; ++j) m(i, j) = first + i * j + 0.1 * (i + j);
  }
  return m;
}

/// Adds to the places of the nodes, one by one.
void AddDense(const std::vector<int>& nodes, const Eigen::MatrixXd& block, Eigen::MatrixXd& sum) {
  for (int i = 0; i < block.rows(); ++i) {
    for (int j = 0; j < block.cols(); ++j) {
      sum(3 * nodes[i / 3] + i % 3, 3 * nodes[j / 3] + j % 3) += block(i, j);
    }
  }
}

TEST(BlockMatrix, SumsBlocksOfNodesInAnyOrder) {
  const std::vector<ElementPatch> patches{{{}, {0, 2, 5}}, {{}, {1, 2}}, {{}, {2, 5, 6}}};
  BlockMatrix matrix(8, patches);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(24, 24);
  const std::vector<std::vector<int>> added{{5, 0, 2}, {2, 1}, {6, 2, 5}, {2, 5}, {2}};
  for (std::size_t n = 0; n < added.size(); ++n) {
    const auto block =
        Symmetric(3 * static_cast<int>(added[n].size()), static_cast<double>(n) + 0.5);
    matrix.Add(added[n], block);
    AddDense(added[n], block, dense);
  }
  const Eigen::SparseMatrix<double> sum = std::move(matrix).Take();
  const Eigen::MatrixXd lower = dense.triangularView<Eigen::Lower>();
  EXPECT_EQ(Eigen::MatrixXd(sum), lower);
  EXPECT_TRUE(sum.isCompressed());
  // Nodes 0, 1, 2, 5 and 6 have a diagonal block; 02, 05, 25, 12, 26 and 56 are coupled.
  EXPECT_EQ(sum.nonZeros(), 5 * 6 + 6 * 9);
}

}  // namespace
}  // namespace acus::mechanics
