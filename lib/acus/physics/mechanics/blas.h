// The few routines of BLAS and LAPACK that this module calls itself. Private to its sources.
#pragma once

extern "C" {
void dgemm_(const char* transpose_a, const char* transpose_b, const int* rows, const int* columns,
            const int* inner, const double* alpha, const double* a, const int* lda, const double* b,
            const int* ldb, const double* beta, double* c, const int* ldc);
void dtrsm_(const char* side, const char* triangle, const char* transpose, const char* diagonal,
            const int* rows, const int* columns, const double* alpha, const double* a,
            const int* lda, double* b, const int* ldb);
void dpotri_(const char* triangle, const int* size, double* a, const int* lda, int* info);
}
