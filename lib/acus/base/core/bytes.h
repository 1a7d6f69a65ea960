// Numbers, arrays and texts in and out of bytes, in the order of bytes that the user states.
#pragma once

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace acus::core {

/// What has a place in bytes: integers and floats of a stated width.
template <typename T>
concept ByteNumber = std::is_arithmetic_v<T> && !std::same_as<T, bool> && sizeof(T) <= 8;

/// Reads from the front. Past the end everything is zero or empty and ok() is false. The bytes must
/// outlive it.
class ByteReader {
 public:
  ByteReader(std::span<const std::uint8_t> bytes, std::endian order)
      : rest_(bytes), order_(order) {}
  ByteReader(std::string_view bytes, std::endian order)
      : ByteReader({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, order) {}

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
  template <ByteNumber T>
  T Number() {
    T value{};
    Copy(Take(sizeof(T)), &value);
    return value;
  }
  /// An array as ByteWriter::Array leaves it: a 64-bit count, and so many numbers.
  template <ByteNumber T>
  std::vector<T> Array() {
    const auto count = Number<std::uint64_t>();
    if (count > rest_.size() / sizeof(T)) {
      Take(rest_.size() + 1);
      return {};
    }
    std::vector<T> out(static_cast<std::size_t>(count));
    Copy(Take(out.size() * sizeof(T)), out.data());
    return out;
  }
  /// A text in a field of `width` bytes, up to its first NUL.
  std::string Text(std::size_t width) {
    const auto field = Take(width);
    const std::string_view text(reinterpret_cast<const char*>(field.data()), field.size());
    return std::string(text.substr(0, text.find('\0')));
  }

 private:
  template <typename T>
  void Copy(std::span<const std::uint8_t> bytes, T* out) const {
    if (bytes.empty()) return;
    std::memcpy(out, bytes.data(), bytes.size());
    if (order_ == std::endian::native) return;
    auto* raw = reinterpret_cast<std::uint8_t*>(out);
    for (std::size_t i = 0; i < bytes.size(); i += sizeof(T)) {
      std::reverse(raw + i, raw + i + sizeof(T));
    }
  }

  std::span<const std::uint8_t> rest_;
  std::endian order_;
  bool ok_ = true;
};

/// Appends to its bytes.
class ByteWriter {
 public:
  explicit ByteWriter(std::endian order) : order_(order) {}

  std::vector<std::uint8_t> bytes;

  template <ByteNumber T>
  void Number(T value) {
    Append(&value, 1);
  }
  template <ByteNumber T>
  void Array(std::span<const T> values) {
    Number(static_cast<std::uint64_t>(values.size()));
    Append(values.data(), values.size());
  }
  /// Cut to `width`, or filled up with NUL.
  void Text(std::string_view text, std::size_t width) {
    text = text.substr(0, width);
    bytes.insert(bytes.end(), text.begin(), text.end());
    bytes.resize(bytes.size() + width - text.size(), 0);
  }
  void Raw(std::span<const std::uint8_t> raw) { bytes.insert(bytes.end(), raw.begin(), raw.end()); }

  std::string AsString() const { return {bytes.begin(), bytes.end()}; }

 private:
  template <typename T>
  void Append(const T* values, std::size_t count) {
    const std::size_t begin = bytes.size();
    const auto* raw = reinterpret_cast<const std::uint8_t*>(values);
    bytes.insert(bytes.end(), raw, raw + count * sizeof(T));
    if (order_ == std::endian::native) return;
    for (std::size_t i = begin; i < bytes.size(); i += sizeof(T)) {
      std::reverse(bytes.data() + i, bytes.data() + i + sizeof(T));
    }
  }

  std::endian order_;
};

}  // namespace acus::core
