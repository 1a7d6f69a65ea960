#include "acus/data/image/png_reader.h"

#include <cstdlib>
#include <string>
#include <string_view>
#include <zlib.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"

namespace acus::image {
namespace {

constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
constexpr std::size_t kMostPixels = 64'000'000;
constexpr std::size_t kHeaderBytes = 13;

std::uint32_t BigEndian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (const char byte : bytes.substr(0, 4)) value = value << 8 | static_cast<std::uint8_t>(byte);
  return value;
}

/// What the file says before its rows (PNG specification, section 11.2.2), and the rows, packed.
struct PackedPng {
  std::size_t width = 0;
  std::size_t height = 0;
  std::size_t channels = 0;
  std::string data;
};

void ReadHeader(std::string_view data, const std::string& file, PackedPng& out) {
  ACUS_REQUIRE(data.size() == kHeaderBytes, file, ": is a damaged PNG: its header has ",
               data.size(), " bytes, not 13; save it again");
  out.width = BigEndian(data);
  out.height = BigEndian(data.substr(4));
  ACUS_REQUIRE(out.width > 0 && out.height > 0 && out.width <= kMostPixels &&
                   out.height <= kMostPixels / out.width,
               file, ": is an image of ", out.width, " x ", out.height,
               " pixels; allowed are 1 to 64 million in all");
  constexpr std::size_t kChannels[] = {1, 0, 3, 0, 2, 0, 4};
  const auto colour = static_cast<std::uint8_t>(data[9]);
  out.channels = colour < std::size(kChannels) ? kChannels[colour] : 0;
  ACUS_REQUIRE(data[8] == 8 && out.channels > 0 && data[12] == 0, file, ": is a PNG of ",
               int{data[8]}, " bits, colour type ", int{colour}, ", interlacing ", int{data[12]},
               "; allowed: 8 bits, grey or RGB (0, 2, 4, 6), not interlaced: save it so");
}

PackedPng Unpacked(std::string_view bytes, const std::string& file) {
  ACUS_REQUIRE(bytes.starts_with(kSignature), file,
               ": is not a PNG: it does not begin as one; save the image as an 8-bit grey PNG");
  PackedPng out;
  for (std::size_t at = kSignature.size(); at + 12 <= bytes.size();) {
    const std::size_t size = BigEndian(bytes.substr(at));
    if (size > bytes.size() - at - 12) break;
    const std::string_view type = bytes.substr(at + 4, 4);
    const std::string_view data = bytes.substr(at + 8, size);
    const auto crc = crc32(0, reinterpret_cast<const Bytef*>(bytes.data() + at + 4),
                           static_cast<uInt>(size + 4));
    ACUS_REQUIRE(crc == BigEndian(bytes.substr(at + 8 + size)), file,
                 ": is a damaged PNG: the checksum of ", type, " at byte ", at,
                 " is wrong; copy or save it again");
    if (type == "IHDR") ReadHeader(data, file, out);
    if (type == "IDAT") out.data.append(data);
    if (type == "IEND") return out;
    at += size + 12;
  }
  throw InputError(Message(file, ": is a damaged PNG: it ends too early; copy or save it again"));
}

int Paeth(int left, int above, int above_left) {
  const int guess = left + above - above_left;
  const int far_left = std::abs(guess - left);
  const int far_above = std::abs(guess - above);
  const int far_corner = std::abs(guess - above_left);
  if (far_left <= far_above && far_left <= far_corner) return left;
  return far_above <= far_corner ? above : above_left;
}

/// Takes the filter off one row (section 9.2). @param above  Zeros for the first.
bool Unfilter(int filter, std::size_t step, const std::uint8_t* above, std::uint8_t* row,
              std::size_t size) {
  if (filter > 4) return false;
  for (std::size_t i = 0; i < size; ++i) {
    const int left = i >= step ? row[i - step] : 0;
    const int corner = i >= step ? above[i - step] : 0;
    const int up = above[i];
    const int guesses[] = {0, left, up, (left + up) / 2, Paeth(left, up, corner)};
    row[i] = static_cast<std::uint8_t>(row[i] + guesses[filter]);
  }
  return true;
}

}  // namespace

GrayImage ReadGreyPng(const std::filesystem::path& path) {
  const std::string file = path.string();
  const PackedPng png = Unpacked(ReadTextFile(path), file);
  const std::size_t row_bytes = png.width * png.channels;
  std::vector<std::uint8_t> raw(png.height * (row_bytes + 1));
  uLongf size = raw.size();
  const int status = uncompress(raw.data(), &size, reinterpret_cast<const Bytef*>(png.data.data()),
                                static_cast<uLong>(png.data.size()));
  ACUS_REQUIRE(status == Z_OK && size == raw.size() && png.channels > 0, file,
               ": is a damaged PNG: its rows cannot be unpacked; copy or save it again");
  GrayImage image;
  image.Resize(static_cast<int>(png.width), static_cast<int>(png.height));
  std::vector<std::uint8_t> zeros(row_bytes, 0);
  const std::uint8_t* above = zeros.data();
  for (std::size_t r = 0; r < png.height; ++r) {
    std::uint8_t* row = raw.data() + r * (row_bytes + 1);
    ACUS_REQUIRE(Unfilter(row[0], png.channels, above, row + 1, row_bytes), file,
                 ": is a damaged PNG: row ", r, " has a filter ", int{row[0]},
                 "; allowed is 0 to 4: save it again");
    above = row + 1;
    for (std::size_t c = 0; c < png.width; ++c) {
      const std::uint8_t* pixel = above + c * png.channels;
      ACUS_REQUIRE(png.channels < 3 || (pixel[0] == pixel[1] && pixel[1] == pixel[2]), file,
                   ": pixel (", c, ", ", r, ") has a colour, ", int{pixel[0]}, " ", int{pixel[1]},
                   " ", int{pixel[2]}, "; save the image in grey, without overlays");
      image.pixels[r * png.width + c] = pixel[0];
    }
  }
  return image;
}

}  // namespace acus::image
