// What a long task is given: seed, threads, where to report progress, when to stop.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "acus/base/core/error.h"
#include "acus/base/core/provenance.h"

namespace acus {

struct RunContext {
  std::uint64_t seed = 0;
  int num_threads = 1;     ///< >= 1. Results never depend on it.
  bool overwrite = false;  ///< An output folder that exists may be replaced.
  Provenance provenance;

  std::function<void(std::string_view task, double fraction)> on_progress;  ///< May be empty.
  std::function<void(std::string_view text)> on_warning;                    ///< May be empty.
  const std::atomic<bool>* stop = nullptr;                                  ///< May be null.

  /// Reports progress in [0, 1] and throws Cancelled if a stop was requested.
  /// Call at most ~100 times per task, from one thread: between slices, not inside voxel loops.
  void Checkpoint(std::string_view task, double fraction) const {
    if (stop != nullptr && stop->load(std::memory_order_relaxed)) throw Cancelled();
    if (on_progress) on_progress(task, fraction);
  }

  /// "Continuing, but ...": something that concerns the user and that the report should carry.
  void Warn(std::string_view text) const {
    if (on_warning) on_warning(text);
  }
};

}  // namespace acus
