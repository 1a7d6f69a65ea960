// One writer, any number of readers, no locks: the newest value of something.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace acus {

/// The writer never waits; a reader tries again if the writer came in between. The value is kept
/// in atomics, word by word, so that reading it meanwhile is no data race.
template <typename T>
class Seqlock {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  /// One thread at a time.
  void Store(const T& value) noexcept {
    Words words{};
    std::memcpy(words.data(), &value, sizeof(T));
    const std::uint64_t version = version_.load(std::memory_order_relaxed);
    version_.store(version + 1, std::memory_order_relaxed);
    for (std::size_t i = 0; i < kNumWords; ++i) {
      // Release: a reader that sees this word sees that the version is odd.
      words_[i].store(words[i], std::memory_order_release);
    }
    version_.store(version + 2, std::memory_order_release);
  }

  /// Any thread. What the last complete Store() wrote; before the first one, all bits zero.
  T Load() const noexcept {
    T value;
    while (!TryLoad(value)) {
      // The writer came in between.
    }
    return value;
  }

  /// For threads that may not wait, not even for a writer that was interrupted: false, and `value`
  /// is as it was, if the writer is at it.
  bool TryLoad(T& value) const noexcept {
    const std::uint64_t before = version_.load(std::memory_order_acquire);
    Words words{};
    for (std::size_t i = 0; i < kNumWords; ++i) {
      words[i] = words_[i].load(std::memory_order_acquire);
    }
    if (version_.load(std::memory_order_relaxed) != before || (before & 1U) != 0) return false;
    std::memcpy(&value, words.data(), sizeof(T));
    return true;
  }

  /// Number of values stored so far.
  std::uint64_t num_stored() const noexcept { return version_.load(std::memory_order_acquire) / 2; }

 private:
  static constexpr std::size_t kNumWords = (sizeof(T) + 7) / 8;
  using Words = std::array<std::uint64_t, kNumWords>;

  std::atomic<std::uint64_t> version_{0};
  std::array<std::atomic<std::uint64_t>, kNumWords> words_{};
};

}  // namespace acus
