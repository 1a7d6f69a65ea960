// A queue between a thread that must never wait and one that may.
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

namespace acus::live {

/// One thread pushes, one takes. Neither waits for the other; nothing is allocated after the
/// constructor. A full ring rejects values.
template <typename T>
class Ring {
 public:
  /// @param capacity  > 0.
  explicit Ring(std::size_t capacity) : slots_(capacity) {}

  /// For the producer. False if the ring is full: nothing changes.
  bool Push(const T& value) noexcept {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    if (end - begin_.load(std::memory_order_acquire) == slots_.size()) return false;
    slots_[end % slots_.size()] = value;
    end_.store(end + 1, std::memory_order_release);
    return true;
  }

  /// For the consumer: the oldest value, to be read before Pop(); null if the ring is empty.
  const T* Front() const noexcept {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    if (begin == end_.load(std::memory_order_acquire)) return nullptr;
    return &slots_[begin % slots_.size()];
  }

  /// For the consumer. @pre Front() is not null.
  void Pop() noexcept {
    begin_.store(begin_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

  /// Any thread; the value may be out of date at once.
  std::size_t size() const noexcept {
    const std::size_t begin = begin_.load(std::memory_order_acquire);
    return end_.load(std::memory_order_acquire) - begin;
  }
  std::size_t capacity() const noexcept { return slots_.size(); }

 private:
  std::vector<T> slots_;
  // On separate cache lines, to avoid false sharing of the two threads.
  alignas(64) std::atomic<std::size_t> begin_{0};
  alignas(64) std::atomic<std::size_t> end_{0};
};

}  // namespace acus::live
