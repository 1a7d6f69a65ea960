#include "acus/physics/mechanics/sparse/elimination_order.h"

#include <algorithm>

#include "acus/base/core/error.h"

namespace acus::mechanics {
namespace {

/// The lower triangle of the graph of the blocks that have a number in `number_of_block`.
CholmodSparse BlockGraph(const Eigen::SparseMatrix<double>& lower, int block,
                         std::span<const int> number_of_block, std::size_t size,
                         CholmodCommon& common) {
  std::vector<SuiteSparse_long> first{0};
  std::vector<SuiteSparse_long> rows;
  std::vector<int> here;
  for (std::size_t column = 0; column < number_of_block.size(); ++column) {
    if (number_of_block[column] < 0) continue;
    here.assign(1, number_of_block[column]);
    for (int k = 0; k < block; ++k) {
      Eigen::SparseMatrix<double>::InnerIterator it(lower, static_cast<int>(column) * block + k);
      for (; it; ++it) {
        const int row = number_of_block[static_cast<std::size_t>(it.row() / block)];
        if (row >= 0 && row != here.back()) here.push_back(row);
      }
    }
    std::ranges::sort(here);
    here.erase(std::unique(here.begin(), here.end()), here.end());
    rows.insert(rows.end(), here.begin(), here.end());
    first.push_back(static_cast<SuiteSparse_long>(rows.size()));
  }
  CholmodSparse out(
      cholmod_l_allocate_sparse(size, size, rows.size(), 1, 1, -1, CHOLMOD_PATTERN, common.get()),
      CholmodDeleter{common.get()});
  RequireCholmodOk(common, nullptr, "ordering the nodes");
  std::ranges::copy(first, static_cast<SuiteSparse_long*>(out->p));
  std::ranges::copy(rows, static_cast<SuiteSparse_long*>(out->i));
  return out;
}

}  // namespace

std::vector<SuiteSparse_long> EliminationOrder(const Eigen::SparseMatrix<double>& lower, int block,
                                               std::span<const int> last, CholmodCommon& common) {
  ACUS_ASSERT(block > 0 && lower.rows() % block == 0);
  // Numbers of the blocks that METIS orders, ascending; those of `last` have none.
  std::vector<int> number(static_cast<std::size_t>(lower.rows() / block), 0);
  for (const int b : last) number[static_cast<std::size_t>(b)] = -1;
  std::vector<int> block_of;
  for (std::size_t b = 0; b < number.size(); ++b) {
    if (number[b] < 0) continue;
    number[b] = static_cast<int>(block_of.size());
    block_of.push_back(static_cast<int>(b));
  }
  std::vector<SuiteSparse_long> order(block_of.size());
  if (!block_of.empty()) {
    const CholmodSparse graph = BlockGraph(lower, block, number, block_of.size(), common);
    cholmod_l_metis(graph.get(), nullptr, 0, 1, order.data(), common.get());
    RequireCholmodOk(common, nullptr, "ordering the nodes");
  }
  for (SuiteSparse_long& b : order) b = block_of[static_cast<std::size_t>(b)];
  order.insert(order.end(), last.begin(), last.end());
  std::vector<SuiteSparse_long> rows;
  rows.reserve(order.size() * static_cast<std::size_t>(block));
  for (const SuiteSparse_long b : order) {
    for (int k = 0; k < block; ++k) rows.push_back(b * block + k);
  }
  return rows;
}

}  // namespace acus::mechanics
