#include "acus/physics/mechanics/sparse/sparse_factor.h"

#include <algorithm>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/physics/mechanics/sparse/cholmod_handles.h"
#include "acus/physics/mechanics/sparse/elimination_order.h"

namespace acus::mechanics {
struct SparseFactor::Impl {
  CholmodCommon common;  // First: the factor is freed with it.
  CholmodFactor factor{nullptr, CholmodDeleter{common.get()}};
  double num_values = 0.0;
  double num_operations = 0.0;

  void Factor(const Eigen::SparseMatrix<double>& lower) {
    const CholmodSparse matrix = ToCholmod(lower, common);
    cholmod_l_factorize(matrix.get(), factor.get(), common.get());
    RequireCholmodOk(common, factor.get(), "factoring the stiffness matrix");
  }
};

SparseFactor::SparseFactor(const Eigen::SparseMatrix<double>& lower, int block)
    : impl_(std::make_unique<Impl>()) {
  ACUS_ASSERT(block > 0 && lower.rows() % block == 0);
  Impl& impl = *impl_;
  std::vector<SuiteSparse_long> order = EliminationOrder(lower, block, {}, impl.common);
  impl.common->method[0].ordering = CHOLMOD_GIVEN;
  const CholmodSparse matrix = ToCholmod(lower, impl.common);
  impl.factor.reset(cholmod_l_analyze_p(matrix.get(), order.data(), nullptr, 0, impl.common.get()));
  RequireCholmodOk(impl.common, nullptr, "ordering the stiffness matrix");
  impl.num_values = impl.common->lnz;
  impl.num_operations = impl.common->fl;
  cholmod_l_factorize(matrix.get(), impl.factor.get(), impl.common.get());
  RequireCholmodOk(impl.common, impl.factor.get(), "factoring the stiffness matrix");
}

SparseFactor::~SparseFactor() = default;
SparseFactor::SparseFactor(SparseFactor&&) noexcept = default;
SparseFactor& SparseFactor::operator=(SparseFactor&&) noexcept = default;

Eigen::MatrixXd SparseFactor::Solve(const Eigen::Ref<const Eigen::MatrixXd>& right_sides) const {
  ACUS_ASSERT(right_sides.rows() == num_rows());
  Eigen::MatrixXd values = right_sides;
  cholmod_dense b{};
  b.nrow = static_cast<std::size_t>(values.rows());
  b.ncol = static_cast<std::size_t>(values.cols());
  b.nzmax = b.nrow * b.ncol;
  b.d = b.nrow;
  b.x = values.data();
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  const CholmodDense x(cholmod_l_solve(CHOLMOD_A, impl_->factor.get(), &b, impl_->common.get()),
                       CholmodDeleter{impl_->common.get()});
  RequireCholmodOk(impl_->common, nullptr, "solving for displacements");
  std::copy_n(static_cast<const double*>(x->x), values.size(), values.data());
  return values;
}

bool SparseFactor::TryRefactor(const Eigen::SparseMatrix<double>& lower) {
  ACUS_ASSERT(lower.rows() == num_rows());
  const CholmodSparse matrix = ToCholmod(lower, impl_->common);
  cholmod_l_factorize(matrix.get(), impl_->factor.get(), impl_->common.get());
  if (impl_->common->status == CHOLMOD_NOT_POSDEF) return false;
  RequireCholmodOk(impl_->common, impl_->factor.get(), "factoring the stiffness matrix");
  return true;
}

void SparseFactor::Refactor(const Eigen::SparseMatrix<double>& lower) {
  ACUS_ASSERT(lower.rows() == num_rows());
  impl_->Factor(lower);
}

int SparseFactor::num_rows() const {
  return static_cast<int>(impl_->factor->n);
}

double SparseFactor::num_values() const {
  return impl_->num_values;
}

double SparseFactor::num_operations() const {
  return impl_->num_operations;
}

}  // namespace acus::mechanics
