#include "acus/data/sound/sound.h"

#include <cmath>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <ios>
#include <sndfile.hh>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/data/sound/cry.h"
#include "support/temporary_folder.h"

namespace acus::sound {
namespace {

using namespace std::string_literals;

class SoundFile : public testing::Test {
 protected:
  Sound Written(const std::string& bytes) {
    std::filesystem::remove(file_);  // Disks are slow at replacing a file.
    std::ofstream(file_, std::ios::binary) << bytes;
    return ReadSound(file_);
  }
  std::string RefusalOf(const std::string& bytes) {
    try {
      Written(bytes);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  /// The bytes of a file of another format, with these values of -1 to 1.
  std::string Encoded(int format, const std::vector<float>& values, int channels = 1,
                      int rate_hz = 44100) {
    {
      SndfileHandle file(file_.string(), SFM_WRITE, format, channels, rate_hz);
      const auto count = static_cast<sf_count_t>(values.size());
      EXPECT_EQ(file.write(values.data(), count), count) << file.strError();
    }
    return ReadTextFile(file_);
  }

  testing_support::TemporaryFolder temporary_;
  std::filesystem::path file_ = temporary_.path() / "a.wav";
};

std::vector<float> Tone(std::size_t count) {
  std::vector<float> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    values[i] = static_cast<float>(0.5 * std::sin(0.05 * static_cast<double>(i)));
  }
  return values;
}

constexpr int kFormats[] = {
    SF_FORMAT_WAV | SF_FORMAT_PCM_U8,  SF_FORMAT_WAV | SF_FORMAT_PCM_24,
    SF_FORMAT_WAV | SF_FORMAT_FLOAT,   SF_FORMAT_WAV | SF_FORMAT_ULAW,
    SF_FORMAT_AIFF | SF_FORMAT_PCM_16, SF_FORMAT_FLAC | SF_FORMAT_PCM_16,
    SF_FORMAT_OGG | SF_FORMAT_VORBIS,
};

TEST_F(SoundFile, GivesBackTheSameSamples) {
  const Sound sound{.rate_hz = 22050, .samples = {0, 1, -1, 32767, -32768, 123}};
  WriteWav(file_, sound);
  const Sound read = ReadSound(file_);
  EXPECT_EQ(read.rate_hz, 22050);
  EXPECT_EQ(read.samples, sound.samples);
}

TEST_F(SoundFile, HasOnlyFormatAndSamples) {
  WriteWav(file_, {.rate_hz = 8000, .samples = {1, -2}});
  EXPECT_EQ(ReadTextFile(file_),
            "RIFF\x28\0\0\0WAVEfmt \x10\0\0\0\1\0\1\0\x40\x1f\0\0\x80\x3e\0\0\2\0\x10\0"
            "data\4\0\0\0\1\0\xfe\xff"s);
}

/// A file of another program: stereo, extensible, with a part that nobody needs.
TEST_F(SoundFile, ReadsStereoOfAnotherProgram) {
  const std::string file =
      "RIFF\0\0\0\0WAVELIST\3\0\0\0abc\0"
      "fmt \x28\0\0\0\xfe\xff\2\0\x40\x1f\0\0\0\x7d\0\0\4\0\x10\0\x16\0\x10\0\3\0\0\0"
      "\1\0\0\0\0\0\x10\0\x80\0\0\xaa\0\x38\x9b\x71"
      "data\x08\0\0\0\x10\0\x20\0\xf0\xff\0\0"s;
  const Sound sound = Written(file);
  EXPECT_EQ(sound.rate_hz, 8000);
  EXPECT_EQ(sound.samples, (std::vector<std::int16_t>{24, -8}));
}

TEST_F(SoundFile, OtherFormatsHaveTheSameLevel) {
  const std::vector<float> values = Tone(44100);
  for (const int format : kFormats) {
    SCOPED_TRACE(Message(std::hex, format));
    const Sound sound = Written(Encoded(format, values));
    ASSERT_EQ(sound.samples.size(), values.size());
    double squares = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      squares += std::pow(sound.samples[i] - 32768.0 * values[i], 2);
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(values.size())), 0.01 * 32768.0);
  }
}

TEST_F(SoundFile, ValuesBeyondFullScaleAreClippedAndNoNumbersRefused) {
  constexpr int kFloats = SF_FORMAT_WAV | SF_FORMAT_FLOAT;
  EXPECT_EQ(Written(Encoded(kFloats, {1.5F, -3e38F, 0.25F})).samples,
            (std::vector<std::int16_t>{32767, -32768, 8192}));
  for (const float value : {std::nanf(""), HUGE_VALF}) {
    EXPECT_THAT(RefusalOf(Encoded(kFloats, {0.0F, value})),
                testing::HasSubstr("sample 1 is no finite number"));
  }
}

TEST_F(SoundFile, SaysWhatIsAllowed) {
  constexpr int kPcm = SF_FORMAT_WAV | SF_FORMAT_PCM_16;
  const std::string mp3 = Encoded(SF_FORMAT_MPEG | SF_FORMAT_MPEG_LAYER_III, Tone(3000));
  for (const std::string& bytes : {"no sound"s, ""s, "RIF"s, mp3}) {
    EXPECT_THAT(RefusalOf(bytes), testing::HasSubstr("is no WAV, AIFF, FLAC or Ogg file; convert"));
  }
  EXPECT_THAT(RefusalOf("RIFF\4\0\0\0WAVE"s), testing::HasSubstr("cannot be read: "));
  EXPECT_THAT(RefusalOf(Encoded(kPcm, Tone(12), 6)),
              testing::HasSubstr("6 channels; allowed are 1 and 2; convert it"));
  EXPECT_THAT(RefusalOf(Encoded(kPcm, Tone(12), 1, 4000)),
              testing::HasSubstr("4000 samples per second; allowed are 8000 to 192000"));
  EXPECT_THAT(RefusalOf(Encoded(kPcm, {})), testing::HasSubstr("it has no sample"));
  EXPECT_THAT(RefusalOf(Encoded(kPcm, Tone(8000 * 61), 1, 8000)),
              testing::HasSubstr("longer than the allowed 60 s"));
  EXPECT_EQ(RefusalOf(Encoded(kPcm, Tone(8000 * 60), 1, 8000)), "");
}

TEST_F(SoundFile, CutOffFilesAreRefusedOrReadAsFarAsTheyGo) {
  const std::string right = Encoded(SF_FORMAT_WAV | SF_FORMAT_PCM_16, Tone(20));
  const std::vector<std::int16_t> all = ReadSound(file_).samples;
  for (std::size_t size = 0; size < right.size(); ++size) {
    SCOPED_TRACE(size);
    if (size < 46) {
      EXPECT_NE(RefusalOf(right.substr(0, size)), "");
      continue;
    }
    const auto read = Written(right.substr(0, size)).samples;
    EXPECT_EQ(read, std::vector(all.begin(), all.begin() + static_cast<int>((size - 44) / 2)));
  }
}

/// Also for sizes of 4 GiB in files of some kilobytes: no more is read than what is there.
TEST_F(SoundFile, DamagedFilesAreRefusedOrReadWithinBounds) {
  RandomStream random(4, "flips");
  for (const int format : kFormats) {
    SCOPED_TRACE(Message(std::hex, format));
    const std::string right = Encoded(format, Tone(3000));
    int refused = 0;
    for (int trial = 0; trial < 1000; ++trial) {
      std::string bytes = right;
      for (int flip = 0; flip < 3; ++flip) {
        bytes[random.Next() % std::min<std::size_t>(60, bytes.size())] =
            static_cast<char>(random.Next());
      }
      if (!RefusalOf(bytes).empty()) ++refused;
    }
    EXPECT_GT(refused, 100);
  }
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
