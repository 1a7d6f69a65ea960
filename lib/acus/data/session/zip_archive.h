// Files inside a zip archive, such as Slicer's .mrb bundles.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace acus::session {

/// An archive that is open for reading. Nothing is unpacked to disk.
class ZipArchive {
 public:
  /// @throws InputError if the file is not a zip archive, or is damaged or encrypted.
  explicit ZipArchive(const std::filesystem::path& path);
  /// An archive that lies in another one. @param label  Stands for the file in messages.
  ZipArchive(std::vector<std::uint8_t> bytes, const std::string& label);
  ~ZipArchive();
  ZipArchive(ZipArchive&&) noexcept;
  ZipArchive& operator=(ZipArchive&&) noexcept;

  /// Names of all files, in their order.
  const std::vector<std::string>& names() const;

  /// The content of a file; its checksum is verified.
  /// @throws InputError if there is none of that name, it is damaged, or has more than `max_bytes`
  ///     bytes (a small archive can hold a huge file of zeros).
  std::vector<std::uint8_t> Read(const std::string& name, std::uint64_t max_bytes) const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace acus::session
