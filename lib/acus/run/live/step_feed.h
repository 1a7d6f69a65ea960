// The inputs of steps, for another computer that computes the same steps.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "acus/data/session/session.h"
#include "acus/run/live/ring.h"

namespace acus::live {

/// All inputs of a step and its images. A plain value of fixed size.
struct StepInput {
  std::int64_t time_ns = 0;    ///< Session time.
  session::PoseSample needle;  ///< The exact input of the step; of the same time, as the others.
  session::PoseSample probe;
  session::BreathSample breath;
  std::optional<double> gain_db;   ///< Of the image; nothing if not changed.
  std::optional<double> depth_mm;  ///< The same.
  double plunger_n = 0.0;          ///< Force of the thumb on the plunger of a syringe.
};

/// Passes inputs from the real-time thread to the sending thread. Neither waits for the other.
class StepFeed {
 public:
  explicit StepFeed(std::size_t capacity) : ring_(capacity) {}

  /// For the real-time thread. A step is lost if the ring is full: later steps are then useless, as
  /// the other computer needs every step.
  void Push(const StepInput& input) noexcept {
    if (closed_.load(std::memory_order_relaxed)) return;
    if (!ring_.Push(input)) lost_.store(true, std::memory_order_relaxed);
  }
  /// Ends the transfer: Push() has no effect any more.
  void Close() noexcept { closed_.store(true, std::memory_order_relaxed); }

  bool lost() const noexcept { return lost_.load(std::memory_order_relaxed); }
  const StepInput* Front() const noexcept { return ring_.Front(); }
  void Pop() noexcept { ring_.Pop(); }

 private:
  Ring<StepInput> ring_;
  std::atomic<bool> closed_{false};
  std::atomic<bool> lost_{false};
};

}  // namespace acus::live
