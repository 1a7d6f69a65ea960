#include "acus/imaging/rf/matlab_elements.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <span>
#include <string_view>
#include <vector>
#include <zlib.h>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"

namespace acus::rf {
namespace {

using ElementBytes = std::span<const std::uint8_t>;

constexpr std::size_t kHeaderBytes = 128;
constexpr std::size_t kTagBytes = 8;
constexpr int kMaxDepth = 32;
/// What zlib can make of a byte at most.
constexpr double kLargestExpansion = 1032.0;

enum ElementType : std::uint32_t { kInt32 = 5, kMatrix = 14, kCompressed = 15 };
enum ArrayClass : std::uint32_t { kCell = 1, kStruct = 2, kObject = 3, kSparse = 5 };

class ElementWalk {
 public:
  ElementWalk(const std::filesystem::path& path, bool swapped) : path_(path), swapped_(swapped) {}

  /// The elements of a file, after its header.
  void WalkFile(ElementBytes bytes) {
    while (!bytes.empty()) {
      const Element element = Take(bytes, kHeaderBytes);
      if (element.type == kMatrix) WalkMatrix(element.data, 1);
      if (element.type != kCompressed) continue;
      const std::vector<std::uint8_t> whole = Inflated(element.data);
      ElementBytes inside(whole);
      if (inside.empty()) continue;
      const Element matrix = Take(inside, 0);
      if (matrix.type == kMatrix) WalkMatrix(matrix.data, 1);
    }
  }

 private:
  struct Element {
    std::uint32_t type = 0;
    ElementBytes data;
  };

  std::uint32_t Word(ElementBytes bytes, std::size_t at) const {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data() + at, sizeof(word));
    return swapped_ ? __builtin_bswap32(word) : word;
  }

  /// The first element of `bytes`, which is taken off. Small ones have their size and their data in
  /// the tag; within a matrix all end at multiples of 8 bytes.
  /// @param outer  0: within an element.
  Element Take(ElementBytes& bytes, std::size_t outer) const {
    Require(bytes.size() >= kTagBytes, "an element is cut off");
    Element element;
    element.type = Word(bytes, 0);
    if (const std::uint32_t small = element.type >> 16U; small != 0) {
      Require(small <= 4, "a small element has more than 4 bytes");
      element.type &= 0xFFFFU;
      element.data = bytes.subspan(4, small);
      bytes = bytes.subspan(kTagBytes);
      return element;
    }
    const std::size_t size = Word(bytes, 4);
    Require(size <= bytes.size() - kTagBytes, "an element ends beyond what holds it");
    element.data = bytes.subspan(kTagBytes, size);
    const std::size_t padded = outer == 0 ? (size + 7) / 8 * 8 : size;
    bytes = bytes.subspan(std::min(kTagBytes + padded, bytes.size()));
    return element;
  }

  void WalkMatrix(ElementBytes bytes, int depth) const {
    Require(depth <= kMaxDepth, "arrays are nested too deep");
    if (bytes.empty()) return;  // An empty array.
    const std::size_t size = bytes.size();
    const Element flags = Take(bytes, 0);
    Require(flags.data.size() >= 8, "an array has no flags");
    const std::uint32_t kind = Word(flags.data, 0) & 0xFFU;
    const Element dims = Take(bytes, 0);
    Require(dims.type == kInt32 && dims.data.size() >= 8, "an array has no dimensions");
    double count = 1.0;
    for (std::size_t at = 0; at + 4 <= dims.data.size(); at += 4) count *= Word(dims.data, at);
    const bool holds_arrays = kind == kCell || kind == kStruct || kind == kObject;
    const double least_bytes = kind == kSparse ? 0.0 : holds_arrays ? kTagBytes * count : count;
    Require(least_bytes <= static_cast<double>(size), "an array declares more values than it has");
    while (!bytes.empty()) {
      const Element element = Take(bytes, 0);
      if (element.type == kMatrix) WalkMatrix(element.data, depth + 1);
    }
  }

  std::vector<std::uint8_t> Inflated(ElementBytes packed) const {
    std::array<std::uint8_t, kTagBytes> tag{};
    Inflate(packed, tag);
    const double declared = kTagBytes + static_cast<double>(Word(tag, 4));
    const auto packed_bytes = static_cast<double>(packed.size());
    Require(declared <= kTagBytes + kLargestExpansion * packed_bytes,
            "a compressed element declares more than it can hold");
    RequireMemory(declared, packed_bytes, path_.string());
    std::vector<std::uint8_t> whole(static_cast<std::size_t>(declared));
    Inflate(packed, whole);
    return whole;
  }

  /// As many bytes as `out` has.
  void Inflate(ElementBytes packed, std::span<std::uint8_t> out) const {
    z_stream stream{};
    ACUS_REQUIRE(inflateInit(&stream) == Z_OK, "zlib cannot be started");
    stream.next_in = const_cast<Bytef*>(packed.data());
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = out.data();
    stream.avail_out = static_cast<uInt>(out.size());
    const int result = inflate(&stream, Z_SYNC_FLUSH);
    const bool sound = (result == Z_OK || result == Z_STREAM_END) && stream.avail_out == 0;
    inflateEnd(&stream);
    Require(sound, "a compressed element is damaged or cut off");
  }

  void Require(bool sound, const char* what) const {
    ACUS_REQUIRE(sound, path_.string(), ": is cut off or damaged (", what,
                 "); copy the file again, or save it again");
  }

  const std::filesystem::path& path_;
  bool swapped_;
};

}  // namespace

void RequireSoundMatlab(const std::filesystem::path& path) {
  std::vector<std::uint8_t> bytes(RequireInputFile(path));
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  // A version 4 file has no mark; the library would take memory for what its first bytes declare.
  std::string_view order;
  if (bytes.size() >= kHeaderBytes) order = {reinterpret_cast<const char*>(&bytes[126]), 2};
  const int version = order == "IM" ? bytes[125] : order == "MI" ? bytes[124] : 0;
  ACUS_REQUIRE(
      version == 1 || version == 2, path.string(),
      ": is not a MATLAB file of version 5, 7 or 7.3; save the channel data with save -v7");
  if (version == 1) {
    ElementWalk(path, order == "MI").WalkFile(ElementBytes(bytes).subspan(kHeaderBytes));
  }
}

}  // namespace acus::rf
