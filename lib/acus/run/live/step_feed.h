// The inputs of steps, for another computer that makes the same steps.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "acus/data/session/session.h"
#include "acus/run/live/ring.h"

namespace acus::live {

/// All that a step and its images depend on. A plain value of fixed size.
struct StepInput {
  std::int64_t time_ns = 0;    ///< Session time.
  session::PoseSample needle;  ///< Exactly as the step got it; of the same time, as the others.
  session::PoseSample probe;
  session::BreathSample breath;
  std::optional<double> gain_db;   ///< Of the image, if somebody has set it.
  std::optional<double> depth_mm;  ///< The same.
  double plunger_n = 0.0;          ///< Force of the thumb on the plunger of a syringe.
};

/// From the real-time thread to the one that sends. Neither waits for the other.
class StepFeed {
 public:
  explicit StepFeed(std::size_t capacity) : ring_(capacity) {}

  /// The real-time thread. A step that finds the ring full is lost: all after it are of no use, as
  /// the other computer has to make every step.
  void Push(const StepInput& input) noexcept {
    if (closed_.load(std::memory_order_relaxed)) return;
    if (!ring_.Push(input)) lost_.store(true, std::memory_order_relaxed);
  }
  /// Nobody takes any more.
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
