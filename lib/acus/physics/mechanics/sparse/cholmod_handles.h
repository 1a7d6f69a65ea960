// Owners of what CHOLMOD allocates. The only door to CHOLMOD; private to the sources of this
// module.
#pragma once

#include <Eigen/SparseCore>
#include <cholmod.h>
#include <memory>
#include <string_view>

namespace acus::mechanics {

/// CHOLMOD's workspace and settings, with long indices: supernodal LL^T, METIS, silent. Holds
/// OpenBLAS to one thread (blas.h).
class CholmodCommon {
 public:
  CholmodCommon();
  ~CholmodCommon();
  CholmodCommon(const CholmodCommon&) = delete;
  CholmodCommon& operator=(const CholmodCommon&) = delete;
  cholmod_common* get() { return &common_; }
  cholmod_common* operator->() { return &common_; }

 private:
  cholmod_common common_;
};

/// Frees with the CholmodCommon that it was made with, which must live longer.
struct CholmodDeleter {
  cholmod_common* common = nullptr;
  void operator()(cholmod_sparse* p) const { cholmod_l_free_sparse(&p, common); }
  void operator()(cholmod_dense* p) const { cholmod_l_free_dense(&p, common); }
  void operator()(cholmod_factor* p) const { cholmod_l_free_factor(&p, common); }
};
using CholmodSparse = std::unique_ptr<cholmod_sparse, CholmodDeleter>;
using CholmodDense = std::unique_ptr<cholmod_dense, CholmodDeleter>;
using CholmodFactor = std::unique_ptr<cholmod_factor, CholmodDeleter>;

/// A copy with long indices of the lower triangle of a symmetric matrix (stype -1).
CholmodSparse ToCholmod(const Eigen::SparseMatrix<double>& lower, CholmodCommon& common);

/// After a call of CHOLMOD. @throws NoAnswerError if it failed: the matrix is not positive definite
/// (with the number of the column), memory ran out, or anything else; `doing` says at what.
void RequireCholmodOk(CholmodCommon& common, const cholmod_factor* factor, std::string_view doing);

}  // namespace acus::mechanics
