#include "acus/data/image/png.h"

#include <span>
#include <string>
#include <zlib.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"

namespace acus::image {
namespace {

void AppendBigEndian(std::string& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) {
    out.push_back(static_cast<char>((value >> shift) & 0xFFU));
  }
}

/// Length, type, data, CRC of type and data (PNG specification, section 5.3).
void AppendChunk(std::string& out, const char* type, std::string_view data) {
  AppendBigEndian(out, static_cast<std::uint32_t>(data.size()));
  const std::size_t begin = out.size();
  out.append(type);
  out.append(data);
  const auto* bytes = reinterpret_cast<const Bytef*>(out.data() + begin);
  AppendBigEndian(
      out, static_cast<std::uint32_t>(crc32(0, bytes, static_cast<uInt>(out.size() - begin))));
}

/// Rows of bytes, top to bottom.
struct Rows {
  int width = 0;
  int height = 0;
  int channels = 1;
  std::span<const std::uint8_t> bytes;

  std::size_t bytes_per_row() const {
    return static_cast<std::size_t>(channels) * static_cast<std::size_t>(width);
  }
};

std::string Compressed(const Rows& image) {
  std::string raw;
  raw.reserve(image.bytes.size() + static_cast<std::size_t>(image.height));
  for (std::size_t r = 0; r < static_cast<std::size_t>(image.height); ++r) {
    raw.push_back(0);  // Row filter: none. Speckle does not profit from any.
    raw.append(reinterpret_cast<const char*>(image.bytes.data() + r * image.bytes_per_row()),
               image.bytes_per_row());
  }
  uLongf size = compressBound(raw.size());
  std::string out(size, '\0');
  const int status = compress2(reinterpret_cast<Bytef*>(out.data()), &size,
                               reinterpret_cast<const Bytef*>(raw.data()), raw.size(), 6);
  ACUS_ASSERT(status == Z_OK);
  out.resize(size);
  return out;
}

void WriteRows(const std::filesystem::path& path, const Rows& image, std::string_view comment) {
  ACUS_REQUIRE(
      image.width > 0 && image.height > 0 &&
          image.bytes.size() == image.bytes_per_row() * static_cast<std::size_t>(image.height),
      path.string(), ": cannot write an image of ", image.width, " x ", image.height,
      " pixels with ", image.bytes.size(), " values");
  std::string header;
  AppendBigEndian(header, static_cast<std::uint32_t>(image.width));
  AppendBigEndian(header, static_cast<std::uint32_t>(image.height));
  const char colour = image.channels == 3 ? 2 : 0;
  header.append({8, colour, 0, 0, 0});  // 8 bits, RGB or grey, standard methods, not interlaced.
  std::string file = "\x89PNG\r\n\x1a\n";
  AppendChunk(file, "IHDR", header);
  if (!comment.empty()) AppendChunk(file, "tEXt", std::string("Comment\0", 8).append(comment));
  AppendChunk(file, "IDAT", Compressed(image));
  AppendChunk(file, "IEND", "");
  WriteTextFile(path, file);
}

}  // namespace

void WritePng(const std::filesystem::path& path, const GrayImage& image, std::string_view comment) {
  WriteRows(path, {image.width, image.height, 1, image.pixels}, comment);
}

void WritePng(const std::filesystem::path& path, const ColourImage& image,
              std::string_view comment) {
  WriteRows(path, {image.width, image.height, 3, image.rgb}, comment);
}

}  // namespace acus::image
