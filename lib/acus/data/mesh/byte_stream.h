// Packs numbers and arrays into bytes, to bring them over from a child process.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "acus/base/core/error.h"

namespace acus::mesh {

class ByteWriter {
 public:
  template <typename T>
  void Put(const T* data, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto size = static_cast<std::uint64_t>(count);
    bytes_.append(reinterpret_cast<const char*>(&size), sizeof size);
    bytes_.append(reinterpret_cast<const char*>(data), count * sizeof(T));
  }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

class ByteReader {
 public:
  explicit ByteReader(const std::string& bytes) : bytes_(bytes) {}

  template <typename T>
  std::vector<T> Get() {
    std::uint64_t count = 0;
    Copy(&count, sizeof count);
    ACUS_ASSERT(count <= (bytes_.size() - at_) / sizeof(T));
    std::vector<T> out(count);
    Copy(out.data(), count * sizeof(T));
    return out;
  }
  /// Columns of `Rows` values.
  template <typename T, int Rows>
  Eigen::Matrix<T, Rows, Eigen::Dynamic> GetColumns() {
    const std::vector<T> values = Get<T>();
    return Eigen::Map<const Eigen::Matrix<T, Rows, Eigen::Dynamic>>(
        values.data(), Rows, static_cast<Eigen::Index>(values.size() / Rows));
  }

 private:
  void Copy(void* out, std::size_t size) {
    ACUS_ASSERT(size <= bytes_.size() - at_);
    if (size > 0) std::memcpy(out, bytes_.data() + at_, size);
    at_ += size;
  }

  const std::string& bytes_;
  std::size_t at_ = 0;
};

}  // namespace acus::mesh
