// Orders of the user, queued for the step that carries them out.
#pragma once

#include <mutex>

#include "acus/data/session/signals.h"
#include "acus/run/live/ring.h"

namespace acus::live {

/// Threads that may wait call Give; the real-time thread calls Take.
class CommandQueue {
 public:
  struct Order {
    session::CommandKind kind = session::CommandKind::kMarkTarget;
    double value = 0.0;
  };

  /// False if the queue of 64 orders is full.
  bool Give(session::CommandKind kind, double value = 0.0) {
    const std::lock_guard lock(givers_);
    return ring_.Push({kind, value});
  }

  /// Called by the real-time thread. False if the queue is empty.
  bool Take(Order& out) noexcept {
    const Order* next = ring_.Front();
    if (next == nullptr) return false;
    out = *next;
    ring_.Pop();
    return true;
  }

 private:
  std::mutex givers_;
  Ring<Order> ring_{64};
};

}  // namespace acus::live
