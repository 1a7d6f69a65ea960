// Ports: the data that stages exchange, by type. A stage declares the ports that it reads and
// writes; the plan is computed from these alone.
#pragma once

#include <array>
#include <string_view>

#include "acus/base/core/error.h"

namespace acus::effects {

/// Ports are compared by the address of their object. The name is for messages only.
class AnyPort {
 public:
  constexpr explicit AnyPort(std::string_view name) : name_(name) {}
  AnyPort(const AnyPort&) = delete;
  AnyPort& operator=(const AnyPort&) = delete;

  constexpr std::string_view name() const noexcept { return name_; }

 private:
  std::string_view name_;
};

/// A port that carries values of type T. One object for each port, of static storage.
template <typename T>
class Port : public AnyPort {
 public:
  using AnyPort::AnyPort;
};

/// A port in a list.
class PortRef {
 public:
  constexpr PortRef(const AnyPort& port) noexcept : port_(&port) {}  // NOLINT: as a reference is.

  constexpr std::string_view name() const noexcept { return port_->name(); }
  friend constexpr bool operator==(PortRef a, PortRef b) noexcept { return a.port_ == b.port_; }

 private:
  const AnyPort* port_;
};

/// The addresses of the ports' current values. Owns no value. Allocates nothing.
class PortValues {
 public:
  static constexpr std::size_t kMaxCount = 32;

  /// Null: the port has no value.
  template <typename T>
  void Set(const Port<T>& port, const T* value) noexcept {
    for (std::size_t i = 0; i < count_; ++i) {
      if (entries_[i].port == &port) {
        entries_[i].value = value;
        return;
      }
    }
    ACUS_ASSERT(count_ < kMaxCount);
    entries_[count_++] = {&port, value};
  }

  /// Null if the port is not set.
  template <typename T>
  const T* Find(const Port<T>& port) const noexcept {
    for (std::size_t i = 0; i < count_; ++i) {
      if (entries_[i].port == &port) return static_cast<const T*>(entries_[i].value);
    }
    return nullptr;
  }

  /// @pre it is set: the plan runs a stage only where every port that it reads has a value.
  template <typename T>
  const T& Get(const Port<T>& port) const noexcept {
    const T* value = Find(port);
    ACUS_ASSERT(value != nullptr);
    return *value;
  }

 private:
  struct Entry {
    const AnyPort* port = nullptr;
    const void* value = nullptr;
  };
  std::array<Entry, kMaxCount> entries_{};
  std::size_t count_ = 0;
};

}  // namespace acus::effects
