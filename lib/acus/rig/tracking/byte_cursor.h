// Numbers and texts in and out of bytes, big end first, as networks have them.
#pragma once

#include <bit>
#include <concepts>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace acus::tracking {

/// Reads from the front. Past the end everything is zero and ok() is false.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : rest_(bytes) {}

  bool ok() const { return ok_; }
  std::size_t left() const { return rest_.size(); }

  std::span<const std::uint8_t> Take(std::size_t count) {
    if (count > rest_.size()) {
      ok_ = false;
      rest_ = {};
      return {};
    }
    const auto taken = rest_.first(count);
    rest_ = rest_.subspan(count);
    return taken;
  }
  template <std::unsigned_integral T>
  T Number() {
    T value = 0;
    for (const std::uint8_t byte : Take(sizeof(T))) value = static_cast<T>(value << 8 | byte);
    return value;
  }
  double Float() { return std::bit_cast<float>(Number<std::uint32_t>()); }
  /// A text in a field of `width` bytes, up to its first NUL.
  std::string Text(std::size_t width) {
    const auto field = Take(width);
    const std::string_view text(reinterpret_cast<const char*>(field.data()), field.size());
    return std::string(text.substr(0, text.find('\0')));
  }

 private:
  std::span<const std::uint8_t> rest_;
  bool ok_ = true;
};

/// Appends to its bytes.
class ByteWriter {
 public:
  std::vector<std::uint8_t> bytes;

  template <std::unsigned_integral T>
  void Number(T value) {
    for (std::size_t i = sizeof(T); i-- > 0;) {
      bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    }
  }
  void Float(double value) { Number(std::bit_cast<std::uint32_t>(static_cast<float>(value))); }
  /// Cut to `width`, or filled up with NUL.
  void Text(std::string_view text, std::size_t width) {
    text = text.substr(0, width);
    bytes.insert(bytes.end(), text.begin(), text.end());
    bytes.resize(bytes.size() + width - text.size(), 0);
  }
  void Raw(std::span<const std::uint8_t> raw) { bytes.insert(bytes.end(), raw.begin(), raw.end()); }
};

}  // namespace acus::tracking
