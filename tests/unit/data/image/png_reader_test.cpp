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

TEST(PngReader, SaysWhatIsWrongWithAFile) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.png";
  EXPECT_THAT(WhyUnread(path), HasSubstr("a.png"));
  WriteTextFile(path, "GIF89a");
  EXPECT_THAT(WhyUnread(path), HasSubstr("a.png: is not a PNG"));
  WritePng(path, Ramp());
  const std::string good = ReadTextFile(path);
  WriteTextFile(path, good.substr(0, good.size() - 20));
  EXPECT_THAT(WhyUnread(path), HasSubstr("a.png: is a damaged PNG: "));
  std::string spoiled = good;
  spoiled[good.size() - 25] = static_cast<char>(spoiled[good.size() - 25] ^ 4);
  WriteTextFile(path, spoiled);
  EXPECT_THAT(WhyUnread(path), HasSubstr("a.png: is a damaged PNG: "));
}

}  // namespace
}  // namespace acus::image
