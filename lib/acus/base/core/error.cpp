#include "acus/base/core/error.h"

#include <cstdio>
#include <cstdlib>

namespace acus {

void AssertionFailed(const char* condition, const char* file, int line) noexcept {
  std::fprintf(stderr, "internal error: %s:%d: broken invariant: %s\n", file, line, condition);
  std::abort();
}

}  // namespace acus
