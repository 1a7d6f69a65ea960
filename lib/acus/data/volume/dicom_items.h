// The elements of a DICOM file with the items of its sequences.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace acus::volume {

/// One data set, or one item of a sequence. Tags are group * 65536 + element.
class DicomItem {
 public:
  using Bytes = std::span<const std::uint8_t>;

  std::map<std::uint32_t, Bytes> values;
  std::map<std::uint32_t, std::vector<DicomItem>> sequences;

  bool Has(std::uint32_t tag) const { return values.contains(tag); }
  /// Without the blanks around it; empty if missing.
  std::string Text(std::uint32_t tag) const;
  /// An unsigned 16-bit value, or `missing`.
  int Short(std::uint32_t tag, int missing) const;
  /// A decimal string of `count` finite numbers; empty if it is missing or not that.
  std::vector<double> Decimals(std::uint32_t tag, std::size_t count) const;
  /// The first item of a sequence, or null.
  const DicomItem* First(std::uint32_t sequence) const;
};

/// A file in memory; the item points into its bytes.
struct DicomDataSet {
  std::vector<std::uint8_t> bytes;
  DicomItem root;
};

/// Reads a file that ReadDicomHeader has accepted: little endian, not deflated.
/// @throws InputError if an item is cut off, broken or nested too deeply, or its pixels are
///     compressed.
DicomDataSet ReadDicomDataSet(const std::filesystem::path& path);

}  // namespace acus::volume
