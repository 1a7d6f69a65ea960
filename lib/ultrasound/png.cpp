#include "ultrasound/png.h"

#include <string>
#include <zlib.h>

#include "core/atomic_file.h"
#include "core/error.h"

namespace acus::ultrasound {
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

std::string Compressed(const GrayImage& image) {
  std::string raw;
  raw.reserve(image.pixels.size() + static_cast<std::size_t>(image.height));
  for (int r = 0; r < image.height; ++r) {
    raw.push_back(0);  // Row filter: none. Speckle does not profit from any.
    const auto first = static_cast<std::size_t>(r) * static_cast<std::size_t>(image.width);
    raw.append(reinterpret_cast<const char*>(image.pixels.data() + first),
               static_cast<std::size_t>(image.width));
  }
  uLongf size = compressBound(raw.size());
  std::string out(size, '\0');
  const int status = compress2(reinterpret_cast<Bytef*>(out.data()), &size,
                               reinterpret_cast<const Bytef*>(raw.data()), raw.size(), 6);
  ACUS_ASSERT(status == Z_OK);
  out.resize(size);
  return out;
}

}  // namespace

void WritePng(const std::filesystem::path& path, const GrayImage& image, std::string_view comment) {
  ACUS_REQUIRE(image.width > 0 && image.height > 0 &&
                   image.pixels.size() == static_cast<std::size_t>(image.width) *
                                              static_cast<std::size_t>(image.height),
               path.string(), ": cannot write a picture of ", image.width, " x ", image.height,
               " pixels with ", image.pixels.size(), " values");
  std::string header;
  AppendBigEndian(header, static_cast<std::uint32_t>(image.width));
  AppendBigEndian(header, static_cast<std::uint32_t>(image.height));
  header.append({8, 0, 0, 0, 0});  // 8 bits, grey, standard methods, not interlaced.
  std::string file = "\x89PNG\r\n\x1a\n";
  AppendChunk(file, "IHDR", header);
  if (!comment.empty()) AppendChunk(file, "tEXt", std::string("Comment\0", 8).append(comment));
  AppendChunk(file, "IDAT", Compressed(image));
  AppendChunk(file, "IEND", "");
  WriteTextFile(path, file);
}

}  // namespace acus::ultrasound
