// The few routines of BLAS and LAPACK that this module calls itself. Private to its sources.
#pragma once

#include <string_view>

extern "C" {
void dgemm_(const char* transpose_a, const char* transpose_b, const int* rows, const int* columns,
            const int* inner, const double* alpha, const double* a, const int* lda, const double* b,
            const int* ldb, const double* beta, double* c, const int* ldc);
void dtrsm_(const char* side, const char* triangle, const char* transpose, const char* diagonal,
            const int* rows, const int* columns, const double* alpha, const double* a,
            const int* lda, double* b, const int* ldb);
void dpotrf_(const char* triangle, const int* size, double* a, const int* lda, int* info);
void dpotri_(const char* triangle, const int* size, double* a, const int* lda, int* info);
}

namespace acus::mechanics {

/// OpenBLAS on one thread, for the whole process: the same matrix gives the same bits, and it is
/// faster for the sizes here.
void HoldBlasToOneThread();

/// The name of the kernels that OpenBLAS runs, such as "Haswell".
std::string_view BlasKernels();

}  // namespace acus::mechanics
