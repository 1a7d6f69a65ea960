// Runs a call into a foreign library in a separate process, because it may crash, exit or hang.
#pragma once

#include <functional>
#include <string>

namespace acus::core {

struct ChildResult {
  enum class End { kDone, kThrew, kThrewNumber, kCrashed, kTimedOut };
  End end = End::kDone;
  std::string bytes;    ///< What the work returned (kDone).
  std::string problem;  ///< The exception's text, the number thrown, or the signal's name.
};

struct ChildLimits {
  double time_s = 60.0;
  double memory_bytes = 8e9;      ///< Address space beyond what the parent has.
  std::function<void()> on_wait;  ///< Called some times per second; may throw to give up.
};

/// Forks, calls `work` in the child with stdout and stderr shut, and brings its bytes back. The
/// child is gone when this returns or throws. `work` must not start threads.
/// @throws InputError if no process can be started, and what on_wait throws.
ChildResult RunInChild(const std::function<std::string()>& work, const ChildLimits& limits);

}  // namespace acus::core
