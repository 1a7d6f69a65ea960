// Passes the newest value from one thread to another, neither of which ever waits.
#pragma once

#include <array>
#include <atomic>

namespace acus::live {

/// One thread writes, one reads. A reader that is slow misses values, never sees half of one, and
/// never delays the writer.
template <typename T>
class TripleBuffer {
 public:
  /// For the writer: fill this, then Publish(). Holds an older value of the writer.
  T& Back() noexcept { return buffers_[back_]; }
  void Publish() noexcept {
    back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kIndex;
  }

  /// For the reader: takes the newest value, if it is a new one. False if not.
  bool Refresh() noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return true;
  }
  /// The last value taken; a T{} before the first.
  const T& Front() const noexcept { return buffers_[front_]; }
  T& Front() noexcept { return buffers_[front_]; }

 private:
  static constexpr unsigned kIndex = 3;
  static constexpr unsigned kFresh = 4;

  std::array<T, 3> buffers_{};
  alignas(64) unsigned back_ = 0;
  alignas(64) std::atomic<unsigned> middle_{1};
  alignas(64) unsigned front_ = 2;
};

}  // namespace acus::live
