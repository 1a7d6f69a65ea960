// The states of the effects' stages, kept from step to step.
#pragma once

#include <array>
#include <cstddef>
#include <cstring>
#include <type_traits>

namespace acus::effects {

/// The states of all stages of effects, one after the other. A plain value of fixed size: it can be
/// copied at any time, from thread to thread, without allocating.
struct Memory {
  static constexpr std::size_t kBytes = 8192;
  static constexpr std::size_t kAlignment = alignof(std::max_align_t);

  alignas(kAlignment) std::array<std::byte, kBytes> bytes{};
};

/// A type that can be the state of a stage.
template <typename T>
concept PlainState = std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T> &&
                     std::is_default_constructible_v<T> && alignof(T) <= Memory::kAlignment;

}  // namespace acus::effects
