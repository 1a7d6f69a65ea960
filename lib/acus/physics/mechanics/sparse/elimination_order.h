// In which order the equations of a mesh are eliminated. Private to this module.
#pragma once

#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "acus/physics/mechanics/sparse/cholmod_handles.h"

namespace acus::mechanics {

/// Order of elimination of the rows of a symmetric matrix: nested dissection (METIS) of the graph
/// of blocks, which is as good as that of rows and takes a fraction of the time; the rows of a
/// block stay together. Blocks of `last` come at the end, as they stand there.
/// @param lower  Lower triangle, compressed.
/// @param block  Rows per block, such as 3 per node.
/// @throws NoAnswerError if memory runs out.
std::vector<SuiteSparse_long> EliminationOrder(const Eigen::SparseMatrix<double>& lower, int block,
                                               std::span<const int> last, CholmodCommon& common);

}  // namespace acus::mechanics
