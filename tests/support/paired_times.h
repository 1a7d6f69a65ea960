// Times of two things done in turns, so that both meet the same noise of a shared machine.
#pragma once

#include <algorithm>
#include <chrono>

#include "acus/base/core/cpu_time.h"

namespace acus::testing_support {

inline double WallMs() {
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// What others do to the machine only ever adds time: the least of many runs is the thing itself.
struct LeastTime {
  double wall_ms = 1e30;
  double cpu_ms = 1e30;  ///< Of the whole process: all its threads.

  template <typename Action>
  void Add(const Action& action) {
    const double cpu_s = ProcessCpuSeconds();
    const double wall = WallMs();
    action();
    wall_ms = std::min(wall_ms, WallMs() - wall);
    cpu_ms = std::min(cpu_ms, 1e3 * (ProcessCpuSeconds() - cpu_s));
  }
};

/// Measures `at_least` times, and on until `holds`, at most `at_most` times: what does hold on this
/// machine holds as soon as others leave it alone for a moment.
template <typename Measure, typename Holds>
void MeasureUntil(int at_least, int at_most, const Measure& measure, const Holds& holds) {
  for (int n = 0; n < at_least || (n < at_most && !holds()); ++n) measure();
}

}  // namespace acus::testing_support
