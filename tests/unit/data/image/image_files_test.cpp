// PNG and film, read back by another library.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/image/film.h"
#include "acus/data/image/png.h"
#include "support/temporary_folder.h"

namespace acus::image {
namespace {

namespace fs = std::filesystem;
using testing_support::TemporaryFolder;

/// Soft shades that depend on the frame, so that frames and places cannot be mixed up.
GrayImage Shades(int width, int height, int frame) {
  GrayImage image;
  image.Resize(width, height);
  for (int r = 0; r < height; ++r) {
    for (int c = 0; c < width; ++c) {
      image.pixels[static_cast<std::size_t>(r * width + c)] =
          static_cast<std::uint8_t>((c * 160 / width + r * 60 / height + 9 * frame) % 256);
    }
  }
  return image;
}

std::size_t NumFiles(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

TEST(WritePng, IsReadBackPixelByPixel) {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 3}, {512, 300}}) {
    const GrayImage image = Shades(width, height, 3);
    WritePng(folder / "a.png", image, "made by a test");
    const cv::Mat read = cv::imread((folder / "a.png").string(), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(read.type(), CV_8UC1);
    ASSERT_EQ(read.cols, width);
    ASSERT_EQ(read.rows, height);
    EXPECT_TRUE(std::equal(image.pixels.begin(), image.pixels.end(), read.data));
  }
  EXPECT_THAT(ReadTextFile(folder / "a.png"), testing::HasSubstr("made by a test"));
}

TEST(WritePng, RefusesAnEmptyImageAndLeavesNothing) {
  const TemporaryFolder folder;
  EXPECT_THROW(WritePng(folder / "a.png", GrayImage{}), InputError);
  GrayImage torn = Shades(4, 4, 0);
  torn.pixels.pop_back();
  EXPECT_THROW(WritePng(folder / "a.png", torn), InputError);
  EXPECT_EQ(NumFiles(folder.path()), 0U);
}

void WriteFilm(const fs::path& path, int width, int height, int frames,
               const FilmOptions& options = {}) {
  FilmWriter film(path, width, height, options);
  for (int n = 0; n < frames; ++n) film.Add(Shades(width, height, n));
  film.Finish();
}

TEST(Film, IsReadBackFrameByFrame) {
  const TemporaryFolder folder;
  WriteFilm(folder / "film.mp4", 320, 240, 12, {.frames_per_s = 25, .quality = 10});
  cv::VideoCapture film((folder / "film.mp4").string());
  ASSERT_TRUE(film.isOpened());
  EXPECT_EQ(film.get(cv::CAP_PROP_FRAME_COUNT), 12);
  EXPECT_NEAR(film.get(cv::CAP_PROP_FPS), 25.0, 1e-6);
  EXPECT_EQ(static_cast<int>(film.get(cv::CAP_PROP_FOURCC)),
            cv::VideoWriter::fourcc('a', 'v', 'c', '1'));
  cv::Mat frame;
  int count = 0;
  for (; film.read(frame); ++count) {
    ASSERT_EQ(frame.cols, 320);
    ASSERT_EQ(frame.rows, 240);
    const GrayImage truth = Shades(320, 240, count);
    double error = 0.0;
    for (int r = 0; r < 240; ++r) {
      for (int c = 0; c < 320; ++c)
        error += std::abs(frame.at<cv::Vec3b>(r, c)[1] - truth.At(c, r));
    }
    EXPECT_LT(error / (320 * 240), 2.5) << "frame " << count;
  }
  EXPECT_EQ(count, 12);
}

/// Four quarters, each of one colour.
ColourImage Quarters(int width, int height) {
  constexpr std::array<std::array<std::uint8_t, 3>, 4> kColours{
      {{200, 40, 30}, {30, 180, 60}, {40, 50, 210}, {230, 220, 40}}};
  ColourImage image;
  image.Resize(width, height);
  for (int r = 0; r < height; ++r) {
    for (int c = 0; c < width; ++c) {
      const auto& colour = kColours[(r < height / 2 ? 0u : 2u) + (c < width / 2 ? 0u : 1u)];
      std::ranges::copy(colour, image.rgb.begin() + 3 * (r * width + c));
    }
  }
  return image;
}

TEST(Film, ColoursAreReadBackWhereTheyWere) {
  for (const auto& [width, height] : {std::pair{128, 96}, {129, 97}}) {
    const TemporaryFolder folder;
    const ColourImage image = Quarters(width, height);
    FilmWriter film(folder / "film.mp4", width, height, {.quality = 2});
    for (int n = 0; n < 3; ++n) film.Add(image);
    film.Finish();
    cv::VideoCapture video((folder / "film.mp4").string());
    cv::Mat frame;
    for (int n = 0; n < 3; ++n) {
      ASSERT_TRUE(video.read(frame));
      // In each quarter, at the corners of the image, and beside the borders between colours.
      for (const int r : {0, 20, height / 2 - 3, height / 2 + 3, height - 1}) {
        for (const int c : {0, 20, width / 2 - 3, width / 2 + 3, width - 1}) {
          const auto seen = frame.at<cv::Vec3b>(r, c);
          for (int channel = 0; channel < 3; ++channel) {
            EXPECT_NEAR(seen[2 - channel],
                        image.rgb[static_cast<std::size_t>(3 * (r * width + c) + channel)], 6)
                << width << " x " << height << " at " << c << ", " << r << " channel " << channel;
          }
        }
      }
    }
  }
}

TEST(Film, GreyIsAsBrightInAColourImage) {
  const TemporaryFolder folder;
  FilmWriter in_grey(folder / "grey.mp4", 64, 64), in_colour(folder / "colour.mp4", 64, 64);
  constexpr int kStep = 16;
  for (int level = 0; level < 256; level += kStep) {
    GrayImage grey;
    grey.Resize(64, 64);
    std::ranges::fill(grey.pixels, static_cast<std::uint8_t>(level));
    in_grey.Add(grey);
    ColourImage colour;
    colour.Resize(64, 64);
    std::ranges::fill(colour.rgb, static_cast<std::uint8_t>(level));
    in_colour.Add(colour);
  }
  in_grey.Finish();
  in_colour.Finish();
  cv::VideoCapture a((folder / "grey.mp4").string()), b((folder / "colour.mp4").string());
  cv::Mat grey, colour;
  double brighter = 0.0;
  for (int level = 0; level < 256; level += kStep) {
    ASSERT_TRUE(a.read(grey) && b.read(colour));
    brighter += (cv::mean(colour)[1] - cv::mean(grey)[1]) * kStep / 256.0;
  }
  EXPECT_NEAR(brighter, 0.0, 0.2);
}

TEST(Film, OddSizesArePaddedByOnePixel) {
  const TemporaryFolder folder;
  WriteFilm(folder / "film.mp4", 101, 77, 3);
  cv::VideoCapture film((folder / "film.mp4").string());
  EXPECT_EQ(film.get(cv::CAP_PROP_FRAME_WIDTH), 102);
  EXPECT_EQ(film.get(cv::CAP_PROP_FRAME_HEIGHT), 78);
}

TEST(Film, TheSameImagesGiveTheSameBytes) {
  const TemporaryFolder folder;
  WriteFilm(folder / "a.mp4", 256, 128, 40);
  WriteFilm(folder / "b.mp4", 256, 128, 40);
  WriteFilm(folder / "c.mp4", 256, 128, 40, {.background = true});
  EXPECT_EQ(ReadTextFile(folder / "a.mp4"), ReadTextFile(folder / "b.mp4"));
  EXPECT_EQ(ReadTextFile(folder / "a.mp4"), ReadTextFile(folder / "c.mp4"));
}

TEST(Film, ABackgroundThatIsLeftEarlyEndsAndLeavesNothing) {
  const TemporaryFolder folder;
  for (const int frames : {0, 1, 30}) {
    FilmWriter film(folder / "film.mp4", 64, 64, {.background = true});
    for (int n = 0; n < frames; ++n) film.Add(Shades(64, 64, n));
    EXPECT_EQ(film.num_frames(), frames);
  }
  EXPECT_EQ(NumFiles(folder.path()), 0U);
}

TEST(Film, AppearsWholeOrNotAtAll) {
  const TemporaryFolder folder;
  {
    FilmWriter film(folder / "film.mp4", 64, 64);
    film.Add(Shades(64, 64, 0));
    EXPECT_THROW(film.Add(Shades(64, 65, 0)), InputError);
    EXPECT_FALSE(fs::exists(folder / "film.mp4"));
  }
  EXPECT_EQ(NumFiles(folder.path()), 0U);
  FilmWriter empty(folder / "film.mp4", 64, 64);
  EXPECT_THROW(empty.Finish(), InputError);
}

TEST(Film, RefusesWhatCannotBeAVideo) {
  const TemporaryFolder folder;
  const auto film = [&](int width, int height, const FilmOptions& options) {
    FilmWriter(folder / "film.mp4", width, height, options);
  };
  EXPECT_THROW(film(15, 64, {}), InputError);
  EXPECT_THROW(film(64, 8193, {}), InputError);
  EXPECT_THROW(film(64, 64, {.frames_per_s = 0.9}), InputError);
  EXPECT_THROW(film(64, 64, {.frames_per_s = 241}), InputError);
  EXPECT_THROW(film(64, 64, {.quality = -1}), InputError);
  EXPECT_THROW(film(64, 64, {.quality = 52}), InputError);
  EXPECT_EQ(NumFiles(folder.path()), 0U);
}

}  // namespace

TEST(VideoLuma, GoesFrom16To235) {
  for (int grey = 0; grey < 256; ++grey) {
    EXPECT_NEAR(VideoLuma(static_cast<std::uint8_t>(grey)), 16.0 + grey * 219.0 / 255.0, 0.75);
  }
  EXPECT_EQ(VideoLuma(0), 16);
  EXPECT_EQ(VideoLuma(255), 235);
}

}  // namespace acus::image
