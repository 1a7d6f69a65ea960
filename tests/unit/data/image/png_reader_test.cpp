#include "acus/data/image/png_reader.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/image/png.h"
#include "support/temporary_folder.h"

namespace acus::image {
namespace {

using testing::HasSubstr;
using testing_support::TemporaryFolder;

std::string WhyUnread(const std::filesystem::path& path) {
  try {
    ReadGreyPng(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

GrayImage Ramp() {
  GrayImage image;
  image.Resize(5, 3);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    image.pixels[i] = static_cast<std::uint8_t>(17 * i);
  }
  return image;
}

TEST(PngReader, ReadsWhatIsWritten) {
  const TemporaryFolder folder;
  WritePng(folder.path() / "a.png", Ramp(), "comment");
  EXPECT_EQ(ReadGreyPng(folder.path() / "a.png").pixels, Ramp().pixels);
  ColourImage grey;
  grey.Resize(5, 3);
  for (std::size_t i = 0; i < 45; ++i) grey.rgb[i] = Ramp().pixels[i / 3];
  WritePng(folder.path() / "b.png", grey);
  EXPECT_EQ(ReadGreyPng(folder.path() / "b.png").pixels, Ramp().pixels);
  grey.rgb[3 * 7 + 1] += 1;
  WritePng(folder.path() / "c.png", grey);
  EXPECT_THAT(WhyUnread(folder.path() / "c.png"),
              HasSubstr("c.png: pixel (2, 1) has a colour, 119 120 119; save the image in grey"));
}

/// A file of 8 x 10 pixels, its rows with the filters 0 to 4 by turns, in two chunks of data.
constexpr unsigned char kFilters[] = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44,
    0x52, 0x00, 0x00, 0x00, 0x08, 0x00, 0x00, 0x00, 0x0a, 0x08, 0x00, 0x00, 0x00, 0x00, 0xac,
    0xac, 0x40, 0x5c, 0x00, 0x00, 0x00, 0x14, 0x49, 0x44, 0x41, 0x54, 0x78, 0xda, 0x63, 0x60,
    0x50, 0xf5, 0xca, 0x9f, 0xb2, 0xf3, 0x1e, 0x33, 0x63, 0xb4, 0x1a, 0x04, 0x30, 0x45, 0xc7,
    0xc4, 0x43, 0x57, 0xee, 0x10, 0x00, 0x00, 0x00, 0x39, 0x49, 0x44, 0x41, 0x54, 0xc6, 0xc5,
    0x27, 0x24, 0x26, 0x31, 0x6f, 0x3b, 0xe4, 0xec, 0xec, 0xe2, 0xe2, 0x7a, 0x94, 0x25, 0x5a,
    0x13, 0x04, 0x12, 0x35, 0x19, 0x8e, 0x7f, 0x94, 0x76, 0xcd, 0x9f, 0x79, 0xf8, 0x2d, 0xa3,
    0x92, 0x36, 0x04, 0x20, 0x14, 0xcf, 0x72, 0x3d, 0xea, 0xe6, 0xe6, 0xee, 0xee, 0xc1, 0x12,
    0x1d, 0xa3, 0x07, 0x02, 0x49, 0x00, 0xbf, 0x1f, 0x1a, 0xd4, 0xac, 0x7e, 0xf0, 0x61, 0x00,
    0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

TEST(PngReader, TakesEveryFilterOff) {
  const TemporaryFolder folder;
  WriteTextFile(folder.path() / "a.png", std::string(std::begin(kFilters), std::end(kFilters)));
  const GrayImage image = ReadGreyPng(folder.path() / "a.png");
  ASSERT_EQ(image.width, 8);
  ASSERT_EQ(image.height, 10);
  for (int r = 0; r < 10; ++r) {
    for (int c = 0; c < 8; ++c) EXPECT_EQ(image.At(c, r), (37 * c + 91 * r + c * r) % 256);
  }
}

TEST(PngReader, SaysWhatIsWrongWithAFile) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.png";
  EXPECT_THAT(WhyUnread(path), HasSubstr("a.png"));
  WriteTextFile(path, "GIF89a");
  EXPECT_THAT(WhyUnread(path), HasSubstr("a.png: is not a PNG"));
  WritePng(path, Ramp());
  const std::string good = ReadTextFile(path);
  WriteTextFile(path, good.substr(0, good.size() - 20));
  EXPECT_THAT(WhyUnread(path), HasSubstr("a.png: is a damaged PNG: it ends too early"));
  std::string spoiled = good;
  spoiled[good.size() - 25] = static_cast<char>(spoiled[good.size() - 25] ^ 4);
  WriteTextFile(path, spoiled);
  EXPECT_THAT(WhyUnread(path), HasSubstr("a.png: is a damaged PNG: the checksum of IDAT"));
}

}  // namespace
}  // namespace acus::image
