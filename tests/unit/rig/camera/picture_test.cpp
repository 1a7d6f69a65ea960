#include "acus/rig/camera/picture.h"

#include <gtest/gtest.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::camera {
namespace {

using testing_support::TemporaryFolder;

Picture Random(int channels) {
  Picture picture;
  picture.Resize(37, 21, channels);
  RandomStream random(4, "picture");
  for (std::uint8_t& level : picture.pixels)
    level = static_cast<std::uint8_t>(random.Next() & 0xff);
  return picture;
}

TEST(Picture, ComesBackAsItWasWritten) {
  const TemporaryFolder folder;
  for (const int channels : {1, 3}) {
    for (const char* name : {"p.png", "p.tif", channels == 1 ? "p.pgm" : "p.ppm"}) {
      const Picture picture = Random(channels);
      WritePicture(folder / name, picture);
      const Picture back = ReadPicture(folder / name);
      EXPECT_EQ(back.channels, channels) << name;
      EXPECT_EQ(back.width_px, 37) << name;
      EXPECT_EQ(back.pixels, picture.pixels) << name;
    }
  }
  EXPECT_THROW(WritePicture(folder / "p.xyz", Random(1)), InputError);
  EXPECT_THROW(WritePicture(folder / "p.png", Picture{}), InputError);
}

TEST(Picture, GreyIsTheLuma) {
  Picture colour;
  colour.Resize(3, 1, 3);
  colour.pixels = {255, 0, 0, 0, 255, 0, 0, 0, 255};
  colour.time_ns = 8;
  Picture grey;
  ToGrey(colour, grey);
  EXPECT_EQ(grey.pixels, (std::vector<std::uint8_t>{76, 150, 29}));
  EXPECT_EQ(grey.time_ns, 8);
}

TEST(Picture, DamagedCopiesAreReadOrRefused) {
  const TemporaryFolder folder;
  for (const char* name : {"p.png", "p.jpg", "p.ppm"}) {
    WritePicture(folder / name, Random(3));
    const int refused =
        testing_support::ReadDamagedCopies(ReadTextFile(folder / name), folder / "damaged", 150,
                                           [&] { ReadPicture(folder / "damaged"); });
    EXPECT_GT(refused, 5) << name;
  }
}

TEST(Picture, SizesThatAreTooLargeAreRefused) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "p.pgm", "P5 30000 30000 255\nabc");
  EXPECT_THROW(ReadPicture(folder / "p.pgm"), InputError);
  EXPECT_THROW(ReadPicture(folder / "none.png"), InputError);
}

}  // namespace
}  // namespace acus::camera
