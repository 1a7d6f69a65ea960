#include "acus/physics/mechanics/sparse/blas.h"

#include <cstdlib>
#include <string_view>

extern "C" {
void openblas_set_num_threads(int num_threads);
char* openblas_get_corename(void);
// How OpenBLAS chooses its kernels when it is loaded. Weak: a build for one processor has neither.
[[gnu::weak]] void gotoblas_dynamic_quit(void);
[[gnu::weak]] void gotoblas_dynamic_init(void);
}

namespace acus::mechanics {
namespace {

constexpr char kVariable[] = "OPENBLAS_CORETYPE";

/// OpenBLAS's name for the best kernels that this processor can run; null: leave its choice.
const char* BestKernels() {
#ifdef __x86_64__
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
    return "SkylakeX";
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return "Haswell";
#endif
  return nullptr;
}

/// OpenBLAS identifies processors by their numbers, and gives one that is newer than itself the
/// kernels of 2004: factors then take twice as long. Whoever names a kernel is obeyed.
bool ChooseKernels() {
  const char* best = BestKernels();
  if (best == nullptr || std::getenv(kVariable) != nullptr) return false;
  if (std::string_view(openblas_get_corename()) != "Prescott") return false;
  if (gotoblas_dynamic_quit == nullptr || gotoblas_dynamic_init == nullptr) return false;
  setenv(kVariable, best, 1);
  gotoblas_dynamic_quit();
  gotoblas_dynamic_init();
  unsetenv(kVariable);
  return true;
}

// Before main, while nothing else runs: the table of kernels is shared by all threads.
[[maybe_unused]] const bool kKernelsWereChosen = ChooseKernels();

}  // namespace

void HoldBlasToOneThread() {
  openblas_set_num_threads(1);
}

std::string_view BlasKernels() {
  return openblas_get_corename();
}

}  // namespace acus::mechanics
