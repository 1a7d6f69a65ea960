#include "acus/rig/camera/image.h"

#include <gtest/gtest.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::camera {
namespace {

using testing_support::TemporaryFolder;

Image Random(int channels) {
  Image image;
  image.Resize(37, 21, channels);
  RandomStream random(4, "image");
  for (std::uint8_t& level : image.pixels) level = static_cast<std::uint8_t>(random.Next() & 0xff);
  return image;
}

TEST(Image, ComesBackAsItWasWritten) {
  const TemporaryFolder folder;
  for (const int channels : {1, 3}) {
    for (const char* name : {"p.png", "p.tif", channels == 1 ? "p.pgm" : "p.ppm"}) {
      const Image image = Random(channels);
      WriteImage(folder / name, image);
      const Image back = ReadImage(folder / name);
      EXPECT_EQ(back.channels, channels) << name;
      EXPECT_EQ(back.width_px, 37) << name;
      EXPECT_EQ(back.pixels, image.pixels) << name;
    }
  }
  EXPECT_THROW(WriteImage(folder / "p.xyz", Random(1)), InputError);
  EXPECT_THROW(WriteImage(folder / "p.png", Image{}), InputError);
}

TEST(Image, GreyIsTheLuma) {
  Image colour;
  colour.Resize(3, 1, 3);
  colour.pixels = {255, 0, 0, 0, 255, 0, 0, 0, 255};
  colour.time_ns = 8;
  Image grey;
  ToGrey(colour, grey);
  EXPECT_EQ(grey.pixels, (std::vector<std::uint8_t>{76, 150, 29}));
  EXPECT_EQ(grey.time_ns, 8);
}

TEST(Image, DamagedCopiesAreReadOrRefused) {
  const TemporaryFolder folder;
  for (const char* name : {"p.png", "p.jpg", "p.ppm"}) {
    WriteImage(folder / name, Random(3));
    const int refused =
        testing_support::ReadDamagedCopies(ReadTextFile(folder / name), folder / "damaged", 150,
                                           [&] { ReadImage(folder / "damaged"); });
    EXPECT_GT(refused, 5) << name;
  }
}

TEST(Image, SizesThatAreTooLargeAreRefused) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "p.pgm", "P5 30000 30000 255\nabc");
  EXPECT_THROW(ReadImage(folder / "p.pgm"), InputError);
  EXPECT_THROW(ReadImage(folder / "none.png"), InputError);
}

}  // namespace
}  // namespace acus::camera
