#include "acus/physics/mechanics/sparse/block_matrix.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "acus/base/core/error.h"

namespace acus::mechanics {
namespace {

/// Nodes with at least the number of each node that share a patch with it: first, rows.
std::pair<std::vector<int>, std::vector<int>> LowerNeighbours(
    int num_nodes, std::span<const ElementPatch> patches) {
  std::vector<std::vector<int>> of_node(static_cast<std::size_t>(num_nodes));
  for (std::size_t g = 0; g < patches.size(); ++g) {
    for (const int node : patches[g].nodes) of_node[node].push_back(static_cast<int>(g));
  }
  std::vector<int> first{0};
  std::vector<int> rows;
  std::vector<int> here;
  for (int node = 0; node < num_nodes; ++node) {
    here.clear();
    for (const int g : of_node[node]) {
      std::ranges::copy_if(patches[g].nodes, std::back_inserter(here),
                           [&](int i) { return i >= node; });
    }
    std::ranges::sort(here);
    here.erase(std::unique(here.begin(), here.end()), here.end());
    rows.insert(rows.end(), here.begin(), here.end());
    first.push_back(static_cast<int>(rows.size()));
  }
  return {std::move(first), std::move(rows)};
}

}  // namespace

BlockMatrix::BlockMatrix(int num_nodes, std::span<const ElementPatch> patches)
    : matrix_(3 * num_nodes, 3 * num_nodes) {
  std::tie(first_, rows_) = LowerNeighbours(num_nodes, patches);
  std::size_t num_values = 0;
  for (int node = 0; node < num_nodes; ++node) {
    const int blocks = first_[node + 1] - first_[node];
    if (blocks > 0) num_values += 9 * static_cast<std::size_t>(blocks) - 3;
  }
  ACUS_REQUIRE(num_values < static_cast<std::size_t>(std::numeric_limits<int>::max()),
               "the mesh is too large: its stiffness has ", num_values,
               " values, 2^31 are allowed; mesh it coarser");
  matrix_.resizeNonZeros(static_cast<Eigen::Index>(num_values));
  int* outer = matrix_.outerIndexPtr();
  int* inner = matrix_.innerIndexPtr();
  int at = 0;
  for (int node = 0; node < num_nodes; ++node) {
    for (int axis = 0; axis < 3; ++axis) {
      outer[3 * node + axis] = at;
      for (int k = first_[node]; k < first_[node + 1]; ++k) {
        for (int row_axis = rows_[k] == node ? axis : 0; row_axis < 3; ++row_axis) {
          inner[at++] = 3 * rows_[k] + row_axis;
        }
      }
    }
  }
  outer[3 * num_nodes] = at;
  std::fill_n(matrix_.valuePtr(), at, 0.0);
}

void BlockMatrix::Add(std::span<const int> nodes, const Eigen::Ref<const Eigen::MatrixXd>& block) {
  for (std::size_t j = 0; j < nodes.size(); ++j) {
    const auto begin = rows_.begin() + first_[nodes[j]];
    const auto end = rows_.begin() + first_[nodes[j] + 1];
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (nodes[i] < nodes[j]) continue;
      const auto k = static_cast<int>(std::lower_bound(begin, end, nodes[i]) - begin);
      for (int axis = 0; axis < 3; ++axis) {
        // The diagonal block, the first, has lost the `axis` values above the diagonal.
        double* values =
            matrix_.valuePtr() + matrix_.outerIndexPtr()[3 * nodes[j] + axis] + 3 * k - axis;
        for (int row = nodes[i] == nodes[j] ? axis : 0; row < 3; ++row) {
          values[row] += block(static_cast<Eigen::Index>(3 * i + row),
                               static_cast<Eigen::Index>(3 * j + axis));
        }
      }
    }
  }
}

}  // namespace acus::mechanics
