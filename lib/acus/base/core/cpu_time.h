// What work costs: CPU time, whatever else the machine does, and memory. Reported, never computed
// with.
#pragma once

#include <ctime>
#include <malloc.h>
#include <sys/resource.h>

namespace acus {

inline double CpuSeconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}
inline double ThreadCpuSeconds() {
  return CpuSeconds(CLOCK_THREAD_CPUTIME_ID);
}
inline double ProcessCpuSeconds() {
  return CpuSeconds(CLOCK_PROCESS_CPUTIME_ID);
}

/// The most memory that this process has held so far, MiB. Pages of mapped files count.
inline double PeakMemoryMib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

/// What this process holds on its heap just now, 10^6 bytes. Mapped files do not count.
inline double HeapMb() {
  const struct mallinfo2 heap = mallinfo2();
  return 1e-6 * static_cast<double>(heap.uordblks + heap.hblkhd);
}

}  // namespace acus
