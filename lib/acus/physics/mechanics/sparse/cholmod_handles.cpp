#include "acus/physics/mechanics/sparse/cholmod_handles.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/physics/mechanics/sparse/blas.h"

namespace acus::mechanics {

CholmodCommon::CholmodCommon() {
  HoldBlasToOneThread();
  cholmod_l_start(&common_);
  common_.print = 0;
  common_.error_handler = nullptr;
  common_.try_catch = 1;  // RequireCholmodOk reports failures.
  common_.useGPU = 0;
  common_.supernodal = CHOLMOD_SUPERNODAL;
  common_.final_ll = 1;
  common_.nmethods = 1;
  common_.method[0].ordering = CHOLMOD_METIS;
  common_.postorder = 1;
  common_.quick_return_if_not_posdef = 1;
}

CholmodCommon::~CholmodCommon() {
  cholmod_l_finish(&common_);
}

CholmodSparse ToCholmod(const Eigen::SparseMatrix<double>& lower, CholmodCommon& common) {
  ACUS_ASSERT(lower.isCompressed() && lower.rows() == lower.cols());
  const auto size = static_cast<std::size_t>(lower.rows());
  CholmodSparse out(
      cholmod_l_allocate_sparse(size, size, static_cast<std::size_t>(lower.nonZeros()), 1, 1, -1,
                                CHOLMOD_REAL, common.get()),
      CholmodDeleter{common.get()});
  RequireCholmodOk(common, nullptr, "copying the stiffness matrix");
  std::copy_n(lower.outerIndexPtr(), size + 1, static_cast<SuiteSparse_long*>(out->p));
  std::copy_n(lower.innerIndexPtr(), lower.nonZeros(), static_cast<SuiteSparse_long*>(out->i));
  std::copy_n(lower.valuePtr(), lower.nonZeros(), static_cast<double*>(out->x));
  return out;
}

void RequireCholmodOk(CholmodCommon& common, const cholmod_factor* factor, std::string_view doing) {
  const int status = common->status;
  if (status == CHOLMOD_NOT_POSDEF) {
    const std::size_t column = factor ? factor->minor : 0;
    const std::size_t equation =
        factor && factor->Perm && column < factor->n
            ? static_cast<std::size_t>(static_cast<const SuiteSparse_long*>(factor->Perm)[column])
            : column;
    throw NoAnswerError(Message(
        doing, ": the matrix is not positive definite at row ", equation,
        "; part of the mesh is held by nothing, or elastic constants differ by more than numbers ",
        "can hold (over 1e12), or tetrahedra are flat"));
  }
  if (status == CHOLMOD_OUT_OF_MEMORY || status == CHOLMOD_TOO_LARGE) {
    throw NoAnswerError(Message(
        doing, ": not enough memory; mesh with fewer nodes, coarser away from the corridor"));
  }
  if (status < 0) throw NoAnswerError(Message(doing, ": CHOLMOD failed with status ", status));
}

}  // namespace acus::mechanics
