// DICOM PS3.5: how the head of a data element (section 7) and its value (6.2) are written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace acus::volume {

using DicomBytes = std::span<const std::uint8_t>;

inline constexpr std::uint32_t kDicomOpenLength = 0xFFFFFFFFU;  ///< Ends at a delimiter.
inline constexpr std::uint32_t kDicomItem = 0xFFFEE000U;
inline constexpr std::uint32_t kDicomItemEnd = 0xFFFEE00DU;
inline constexpr std::uint32_t kDicomSequenceEnd = 0xFFFEE0DDU;
inline constexpr std::uint32_t kDicomPixels = 0x7FE00010U;
inline constexpr std::uint32_t kDicomTransferSyntax = 0x00020010U;
inline constexpr int kMostDicomDepth = 32;  ///< Of sequences in sequences.

/// Little endian. @pre the bytes are there.
inline std::uint32_t DicomU16(DicomBytes bytes, std::size_t at) {
  return bytes[at] | static_cast<std::uint32_t>(bytes[at + 1]) << 8U;
}
inline std::uint32_t DicomU32(DicomBytes bytes, std::size_t at) {
  return DicomU16(bytes, at) | DicomU16(bytes, at + 2) << 16U;
}
/// group * 65536 + element.
inline std::uint32_t DicomTag(DicomBytes bytes, std::size_t at) {
  return DicomU16(bytes, at) << 16U | DicomU16(bytes, at + 2);
}

/// Whether a type in capitals follows the tag; false beyond the end.
bool DicomLooksExplicit(DicomBytes bytes, std::size_t at);

struct DicomHead {
  std::uint32_t tag = 0;
  std::string type;          ///< Two capitals; empty if the file does not give it.
  std::uint32_t length = 0;  ///< Of the value; 0 if the head itself is cut off.
  std::size_t size = 8;      ///< Of the head, bytes.
};

/// @param is_explicit  The transfer syntax gives types; an element without one is read all the
/// same.
/// @pre 8 bytes are there. Whether `size` bytes are is for the caller to see.
DicomHead ReadDicomHead(DicomBytes bytes, std::size_t at, bool is_explicit);

/// Values by tag, as texts and numbers.
struct DicomValues {
  std::map<std::uint32_t, DicomBytes> values;

  bool Has(std::uint32_t tag) const { return values.contains(tag); }
  /// Without the blanks around it; empty if missing.
  std::string Text(std::uint32_t tag) const;
  /// An unsigned 16-bit value, or `missing`.
  int Short(std::uint32_t tag, int missing) const;
  /// An unsigned 32-bit value, or `missing`.
  int Long(std::uint32_t tag, int missing) const;
  /// A decimal string of `count` finite numbers; empty if it is missing or not that.
  std::vector<double> Decimals(std::uint32_t tag, std::size_t count) const;
};

inline constexpr const char* kDicomDeflated = "1.2.840.10008.1.2.1.99";

/// A file of at most 4 GB; the data set of a deflated one is inflated.
/// @throws InputError if it cannot be read, or its compressed data is broken or larger than memory.
std::vector<std::uint8_t> ReadDicomBytes(const std::filesystem::path& path);

}  // namespace acus::volume
