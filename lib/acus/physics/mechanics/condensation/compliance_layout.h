// How a compliance file lies on disk. Private to its reader and writer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace acus::mechanics {

inline constexpr char kComplianceMagic[8] = {'A', 'C', 'U', 'S', 'C', 'M', 'P', 'L'};
inline constexpr std::uint32_t kComplianceVersion = 1;
inline constexpr std::uint32_t kByteOrder = 0x01020304;
inline constexpr std::uint32_t kOtherByteOrder = 0x04030201;
inline constexpr std::uint64_t kPageBytes = 4096;
inline constexpr std::uint64_t kPieceBytes = std::uint64_t{4} << 20U;  ///< Per checksum.
inline constexpr std::uint32_t kMostNodes = 1U << 24U;  ///< Keeps sizes within 64 bits.

/// The first page, followed by zeros. Numbers are little-endian, texts padded with zeros.
struct ComplianceHeader {
  char magic[8];
  std::uint32_t byte_order;
  std::uint32_t version;
  std::uint64_t file_bytes;
  std::uint32_t num_nodes;
  std::uint32_t num_visible;
  std::uint32_t value_bytes;  ///< 4: float, 8: double.
  std::uint32_t num_mesh_nodes;
  char element[32];
  char mesh_sha256[64];
  char elasticity_sha256[64];
  char key[64];                ///< SHA-256 of all that the content depends on.
  std::uint64_t tables_check;  ///< Of the tables, to the end of their last page.
  std::uint64_t header_check;  ///< Of the first page, with zero here.
};
static_assert(sizeof(ComplianceHeader) == 280);

/// Where things are: header, tables (reachable nodes, visible nodes, checksums of the pieces of
/// both matrices), compliance, image block; each begins on a page.
struct ComplianceLayout {
  std::uint64_t nodes_at = kPageBytes;
  std::uint64_t visible_at = 0;
  std::uint64_t checks_at = 0;
  std::uint64_t num_compliance_pieces = 0;
  std::uint64_t num_image_pieces = 0;
  std::uint64_t compliance_at = 0;
  std::uint64_t compliance_bytes = 0;
  std::uint64_t image_at = 0;
  std::uint64_t image_bytes = 0;
  std::uint64_t file_bytes = 0;

  ComplianceLayout(std::uint64_t num_nodes, std::uint64_t num_visible, std::uint64_t value_bytes) {
    const auto up_to = [](std::uint64_t at, std::uint64_t step) {
      return (at + step - 1) / step * step;
    };
    compliance_bytes = 9 * num_nodes * num_nodes * value_bytes;
    image_bytes = 9 * num_nodes * num_visible * sizeof(float);
    num_compliance_pieces = up_to(compliance_bytes, kPieceBytes) / kPieceBytes;
    num_image_pieces = up_to(image_bytes, kPieceBytes) / kPieceBytes;
    visible_at = nodes_at + num_nodes * sizeof(std::int32_t);
    checks_at = up_to(visible_at + num_visible * sizeof(std::int32_t), sizeof(std::uint64_t));
    compliance_at = up_to(
        checks_at + (num_compliance_pieces + num_image_pieces) * sizeof(std::uint64_t), kPageBytes);
    image_at = up_to(compliance_at + compliance_bytes, kPageBytes);
    file_bytes = image_at + image_bytes;
  }
};

/// 64 bits that detect damage, not malice, at the speed of memory: 64-bit words are multiplied into
/// four lanes, and high bits are brought down, so that they count, too. Every step can be undone,
/// so that a change within one word always shows.
inline std::uint64_t Checksum(const void* bytes, std::uint64_t size) {
  constexpr std::uint64_t kOdd = 0x9e3779b97f4a7c15;
  std::uint64_t lanes[4] = {0xcbf29ce484222325, 0x9ae16a3b2f90404f, 0xc3a5c85c97cb3127, size};
  const char* at = static_cast<const char*>(bytes);
  const auto mixed = [](std::uint64_t value) {
    value *= kOdd;
    return value ^ (value >> 32U);
  };
  const auto add = [&](const char* block) {
    std::uint64_t words[4];
    std::memcpy(words, block, sizeof words);
    for (int k = 0; k < 4; ++k) lanes[k] = mixed(lanes[k] ^ words[k]);
  };
  std::uint64_t left = size;
  for (; left >= 32; left -= 32, at += 32) add(at);
  if (left > 0) {
    char rest[32] = {};
    std::memcpy(rest, at, left);
    add(rest);
  }
  std::uint64_t sum = 0;
  for (const std::uint64_t lane : lanes) sum = mixed(sum ^ lane);
  return sum;
}

}  // namespace acus::mechanics
