// Waiting for what another thread or process will do.
#pragma once

#include <functional>
#include <unistd.h>

#include "acus/base/core/monotonic_time.h"

namespace acus::testing_support {

/// Looks every millisecond. False if it did not come about in `seconds`, which are many, so that a
/// loaded machine does not fail.
inline bool WaitUntil(const std::function<bool()>& what, double seconds = 20.0) {
  const auto end_ns = MonotonicNs() + static_cast<std::int64_t>(1e9 * seconds);
  while (!what()) {
    if (MonotonicNs() > end_ns) return false;
    usleep(1000);
  }
  return true;
}

}  // namespace acus::testing_support
