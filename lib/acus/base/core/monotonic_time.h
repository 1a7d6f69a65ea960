// The one clock of live programs.
#pragma once

#include <cstdint>
#include <ctime>

namespace acus {

/// CLOCK_MONOTONIC in ns: never set back, the same for all threads and processes of a machine.
/// Only devices, trackers and what runs them may ask (tests/checks/source_rules_test.cpp has the
/// list): models get their time from the samples.
inline std::int64_t MonotonicNs() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

}  // namespace acus
