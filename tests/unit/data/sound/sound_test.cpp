#include "acus/data/sound/sound.h"

#include <gtest/gtest.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/data/sound/cry.h"
#include "support/temporary_folder.h"

namespace acus::sound {
namespace {

class Wav : public testing::Test {
 protected:
  Sound Written(const std::string& bytes) {
    WriteTextFile(file_, bytes);
    return ReadWav(file_);
  }
  std::string RefusalOf(const std::string& bytes) {
    try {
      Written(bytes);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  testing_support::TemporaryFolder temporary_;
  std::filesystem::path file_ = temporary_.path() / "a.wav";
};

TEST_F(Wav, GivesBackTheSameSamples) {
  const Sound sound{.rate_hz = 22050, .samples = {0, 1, -1, 32767, -32768, 123}};
  WriteWav(file_, sound);
  const Sound read = ReadWav(file_);
  EXPECT_EQ(read.rate_hz, 22050);
  EXPECT_EQ(read.samples, sound.samples);
}

/// A file of another program: stereo, extensible, with a part that nobody needs.
TEST_F(Wav, ReadsStereoOfAnotherProgram) {
  using namespace std::string_literals;
  const std::string file =
      "RIFF\0\0\0\0WAVELIST\3\0\0\0abc\0"
      "fmt \x28\0\0\0\xfe\xff\2\0\x40\x1f\0\0\0\x7d\0\0\4\0\x10\0\x16\0\x10\0\3\0\0\0"
      "\1\0\0\0\0\0\x10\0\x80\0\0\xaa\0\x38\x9b\x71"
      "data\x08\0\0\0\x10\0\x20\0\xf0\xff\0\0"s;
  const Sound sound = Written(file);
  EXPECT_EQ(sound.rate_hz, 8000);
  EXPECT_EQ(sound.samples, (std::vector<std::int16_t>{24, -8}));
}

TEST_F(Wav, DamagedFilesAreRefusedOrReadWithinBounds) {
  WriteWav(file_, {.rate_hz = 44100, .samples = std::vector<std::int16_t>(20, 5)});
  const std::string right = ReadTextFile(file_);
  for (std::size_t size = 0; size < right.size(); ++size) {
    EXPECT_NE(RefusalOf(right.substr(0, size)), "") << size;
  }
  RandomStream random(4, "flips");
  int refused = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    std::string bytes = right;
    bytes[random.Next() % 44] = static_cast<char>(random.Next());
    if (!RefusalOf(bytes).empty()) ++refused;
  }
  EXPECT_GT(refused, 1000);
  std::string bytes = right;
  bytes[34] = 24;
  EXPECT_NE(RefusalOf(bytes).find("24 bits; allowed is PCM (1) with 16 bits"), std::string::npos);
  bytes = right;
  bytes[22] = 6;
  EXPECT_NE(RefusalOf(bytes).find("6 channels; allowed are 1 and 2"), std::string::npos);
  WriteWav(file_, {.rate_hz = 8000, .samples = std::vector<std::int16_t>(8000 * 61, 5)});
  EXPECT_THROW(ReadWav(file_), InputError) << "longer than a minute";
}

TEST(Track, HasTheSoundAtEachTime) {
  const Sound sound{.rate_hz = 10000, .samples = {100, -20000, 20000}};
  const Sound track = TrackOf(sound, {0.0005, 0.0006, 0.002}, 0.0015);
  ASSERT_EQ(track.samples.size(), 23U);
  std::vector<std::int16_t> expected(23, 0);
  expected[5] = 100;
  expected[6] = -19900;
  expected[7] = 0;
  expected[8] = 20000;
  expected[20] = 100;
  expected[21] = -20000;
  expected[22] = 20000;
  EXPECT_EQ(track.samples, expected);
  EXPECT_EQ(TrackOf(sound, {0.001, 0.001}, 0.0).samples[12], 32767) << "within full scale";
  EXPECT_EQ(TrackOf(sound, {}, 0.001).samples, std::vector<std::int16_t>(10, 0));
}

}  // namespace
}  // namespace acus::sound
