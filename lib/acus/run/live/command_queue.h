// Orders of the user, on their way to the step that carries them out.
#pragma once

#include <mutex>

#include "acus/data/session/signals.h"
#include "acus/run/live/ring.h"

namespace acus::live {

/// Any thread that may wait gives orders; one that may not takes them.
class CommandQueue {
 public:
  struct Order {
    session::CommandKind kind = session::CommandKind::kMarkTarget;
    double value = 0.0;
  };

  /// False if 64 orders wait already: nobody types so fast.
  bool Give(session::CommandKind kind, double value = 0.0) {
    const std::lock_guard lock(givers_);
    return ring_.Push({kind, value});
  }

  /// The real-time thread. False if there is none.
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
