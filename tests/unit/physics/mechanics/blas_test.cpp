#include "acus/physics/mechanics/sparse/blas.h"

#include <cstdlib>
#include <gtest/gtest.h>

namespace acus::mechanics {
namespace {

#ifdef __x86_64__
// Fails where OpenBLAS does not know the processor and the choice is left to it.
TEST(Blas, RunsKernelsOfThisProcessorsVectors) {
  if (std::getenv("OPENBLAS_CORETYPE") != nullptr) GTEST_SKIP() << "OPENBLAS_CORETYPE is set";
  if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "this processor has no AVX2";
  EXPECT_NE(BlasKernels(), "Prescott");
}
#endif

}  // namespace
}  // namespace acus::mechanics
