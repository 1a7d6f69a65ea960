#include "acus/physics/mechanics/condensation/condensed_factor.h"

#include <algorithm>
#include <cmath>
#include <malloc.h>
#include <numeric>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/physics/mechanics/sparse/blas.h"
#include "acus/physics/mechanics/sparse/cholmod_handles.h"
#include "acus/physics/mechanics/sparse/elimination_order.h"

namespace acus::mechanics {
namespace {

static_assert(sizeof(long) == sizeof(SuiteSparse_long));

/// Zeros are stored in the first column of the last block, so that the block becomes one dense
/// supernode at the end of the factor, whatever parts the mesh falls into without it.
void CoupleLast(Eigen::SparseMatrix<double>& lower, std::span<const int> last) {
  const int column = 3 * last.front();
  std::vector<Eigen::Triplet<double>> zeros;
  for (const int node : last) {
    for (int axis = 0; axis < 3; ++axis) zeros.emplace_back(3 * node + axis, column, 0.0);
  }
  Eigen::SparseMatrix<double> chain(lower.rows(), lower.cols());
  chain.setFromTriplets(zeros.begin(), zeros.end());
  lower = Eigen::SparseMatrix<double>(lower + chain);
}

/// The lower triangle of P K P^T. CHOLMOD would do this itself, with two more copies of K in memory
/// beside the factor.
CholmodSparse Permuted(const Eigen::SparseMatrix<double>& lower, std::span<const long> order,
                       CholmodCommon& common) {
  const auto size = static_cast<std::size_t>(lower.rows());
  std::vector<long> rank(size);
  for (std::size_t k = 0; k < size; ++k) rank[order[k]] = static_cast<long>(k);
  std::vector<long> next(size + 1, 0);
  const auto for_each = [&](const auto& visit) {
    for (int j = 0; j < lower.outerSize(); ++j) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(lower, j); it; ++it) {
        const auto [column, row] = std::minmax(rank[j], rank[it.row()]);
        visit(column, row, it.value());
      }
    }
  };
  for_each([&](long column, long, double) { ++next[column + 1]; });
  std::partial_sum(next.begin(), next.end(), next.begin());
  CholmodSparse out(
      cholmod_l_allocate_sparse(size, size, static_cast<std::size_t>(lower.nonZeros()), 0, 1, -1,
                                CHOLMOD_REAL, common.get()),
      CholmodDeleter{common.get()});
  RequireCholmodOk(common, nullptr, "ordering the stiffness matrix");
  std::ranges::copy(next, static_cast<long*>(out->p));
  auto* rows = static_cast<long*>(out->i);
  auto* values = static_cast<double*>(out->x);
  for_each([&](long column, long row, double value) {
    rows[next[column]] = row;
    values[next[column]++] = value;
  });
  return out;
}

/// Copies the lower triangle over the upper one, in tiles that stay in the cache.
void Mirror(double* values, long size, long stride) {
  constexpr long kTile = 64;
  for (long column = 0; column < size; column += kTile) {
    const long columns = std::min(kTile, size - column);
    for (long row = column; row < size; row += kTile) {
      const long rows = std::min(kTile, size - row);
      for (long j = 0; j < columns; ++j) {
        for (long i = 0; i < rows; ++i) {
          if (row + i > column + j) {
            values[(row + i) * stride + column + j] = values[(column + j) * stride + row + i];
          }
        }
      }
    }
  }
}

}  // namespace

struct CondensedFactor::Impl {
  CholmodCommon common;  // First: the factor is freed with it.
  CholmodFactor factor{nullptr, CholmodDeleter{common.get()}};
  double* block = nullptr;  ///< The last block, first L22, then the compliance.
  long size = 0;            ///< Its rows.
  long stride = 0;

  void Analyze(cholmod_sparse& matrix, std::vector<long> order, double max_memory_mib);
  void FindLastBlock(std::span<const int> last);
  void Invert();
};

void CondensedFactor::Impl::Analyze(cholmod_sparse& matrix, std::vector<long> order,
                                    double max_memory_mib) {
  common->method[0].ordering = CHOLMOD_GIVEN;
  // Larger supernodes make the dense kernels faster; large ones may not cost stored zeros, which
  // would be memory.
  constexpr std::size_t kColumns[] = {4, 16, 64};
  constexpr double kZeros[] = {0.2, 0.01, 0.0};
  std::ranges::copy(kColumns, common->nrelax);
  std::ranges::copy(kZeros, common->zrelax);
  factor.reset(cholmod_l_analyze_p(&matrix, order.data(), nullptr, 0, common.get()));
  RequireCholmodOk(common, nullptr, "ordering the stiffness matrix");
  const double mib =
      8.0 * static_cast<double>(factor->xsize + factor->maxcsize) / (1024.0 * 1024.0);
  if (mib > max_memory_mib) {
    throw NoAnswerError(Message("condensing to ", size / 3, " nodes needs ", std::ceil(mib),
                                " MiB, more than the ", max_memory_mib,
                                " allowed (max_memory_mib); choose a narrower corridor, a smaller "
                                "patch of skin or coarser elements"));
  }
}

void CondensedFactor::Impl::FindLastBlock(std::span<const int> last) {
  const auto* first_column = static_cast<const long*>(factor->super);
  const auto* first_value = static_cast<const long*>(factor->px);
  const long num_rows = static_cast<long>(factor->n);
  const long group = static_cast<long>(factor->nsuper) - 1;
  const long before = num_rows - size - first_column[group];
  // Ordering by the elimination tree has moved nothing into the last block, nor within it.
  const auto* order = static_cast<const long*>(factor->Perm) + (num_rows - size);
  bool is_in_place = before >= 0;
  for (std::size_t k = 0; k < last.size(); ++k) is_in_place &= order[3 * k] == 3L * last[k];
  ACUS_ASSERT(is_in_place);
  stride = num_rows - first_column[group];
  block = static_cast<double*>(factor->x) + first_value[group] + before * stride + before;
}

void CondensedFactor::Impl::Invert() {
  const int rows = static_cast<int>(size);
  const int between = static_cast<int>(stride);
  int info = 0;
  dpotri_("L", &rows, block, &between, &info);
  ACUS_ASSERT(info == 0);  // The factor has no zero on its diagonal.
  Mirror(block, size, stride);
}

CondensedFactor::CondensedFactor(Eigen::SparseMatrix<double>&& lower_n_per_mm,
                                 std::span<const int> last, double max_memory_mib,
                                 const RunContext& context)
    : impl_(std::make_unique<Impl>()) {
  ACUS_ASSERT(!last.empty() && std::ranges::is_sorted(last));
  Impl& impl = *impl_;
  impl.size = 3L * static_cast<long>(last.size());
  context.Checkpoint("ordering the nodes", 0.05);
  std::vector<long> order = EliminationOrder(lower_n_per_mm, 3, last, impl.common);
  CoupleLast(lower_n_per_mm, last);
  impl.Analyze(*ToCholmod(lower_n_per_mm, impl.common), std::move(order), max_memory_mib);
  const CholmodSparse matrix = Permuted(
      lower_n_per_mm, {static_cast<const long*>(impl.factor->Perm), impl.factor->n}, impl.common);
  Eigen::SparseMatrix<double>().swap(lower_n_per_mm);  // Gives its memory back; resize() would not.
  impl.factor->ordering = CHOLMOD_NATURAL;             // It is in order already.
  malloc_trim(0);  // What assembly left in small pieces, about 200 MiB, is for the factor to have.
  context.Checkpoint("factoring the stiffness", 0.1);
  cholmod_l_factorize(matrix.get(), impl.factor.get(), impl.common.get());
  RequireCholmodOk(impl.common, impl.factor.get(), "factoring the stiffness matrix");
  impl.FindLastBlock(last);
  context.Checkpoint("inverting the last block", 0.5);
  impl.Invert();
}

CondensedFactor::~CondensedFactor() = default;
CondensedFactor::CondensedFactor(CondensedFactor&&) noexcept = default;
CondensedFactor& CondensedFactor::operator=(CondensedFactor&&) noexcept = default;

CondensedFactor::View CondensedFactor::ComplianceMmPerN() const {
  return {impl_->block, impl_->size, impl_->size, Eigen::OuterStride<>(impl_->stride)};
}

Supernodes CondensedFactor::supernodes() const {
  const cholmod_factor& factor = *impl_->factor;
  return {static_cast<int>(factor.nsuper),     static_cast<const long*>(factor.super),
          static_cast<const long*>(factor.pi), static_cast<const long*>(factor.px),
          static_cast<const long*>(factor.s),  static_cast<const double*>(factor.x)};
}

std::span<const long> CondensedFactor::order() const {
  return {static_cast<const long*>(impl_->factor->Perm), impl_->factor->n};
}

double CondensedFactor::num_values() const {
  return static_cast<double>(impl_->factor->xsize);
}

}  // namespace acus::mechanics
