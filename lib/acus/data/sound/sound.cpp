#include "acus/data/sound/sound.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sndfile.hh>
#include <string_view>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"

namespace acus::sound {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFramesAtOnce = 4096;
constexpr double kFullScale = 32768.0;
constexpr const char* kTry =
    "; convert it, for example with ffmpeg -i IN -ac 1 -ar 44100 -sample_fmt s16 -t 60 OUT.wav";

/// WAV, AIFF, FLAC, Ogg. libsndfile reads more, but takes some formats from the name alone, and its
/// decoder of MP3 writes messages of its own.
constexpr std::string_view kBegins[] = {"RIFF", "FORM", "fLaC", "OggS"};

void CheckBegin(const fs::path& path) {
  RequireInputFile(path);
  std::string begin(kBegins[0].size(), '\0');
  std::ifstream(path, std::ios::binary)
      .read(begin.data(), static_cast<std::streamsize>(begin.size()));
  ACUS_REQUIRE(std::ranges::count(kBegins, begin) == 1, path.string(),
               ": is no WAV, AIFF, FLAC or Ogg file", kTry);
}

void Check(const SndfileHandle& file, const std::string& where) {
  ACUS_REQUIRE(file.channels() == 1 || file.channels() == 2, where, ": ", file.channels(),
               " channels; allowed are 1 and 2", kTry);
  ACUS_REQUIRE(file.samplerate() >= kLeastRateHz && file.samplerate() <= kLargestRateHz, where,
               ": ", file.samplerate(), " samples per second; allowed are ", kLeastRateHz, " to ",
               kLargestRateHz, kTry);
}

std::int16_t SampleOf(double value) {
  return static_cast<std::int16_t>(
      std::lround(std::clamp(kFullScale * value, -kFullScale, kFullScale - 1.0)));
}

}  // namespace

Sound ReadSound(const fs::path& path) {
  const std::string where = path.string();
  CheckBegin(path);
  SndfileHandle file(where);
  ACUS_REQUIRE(file.rawHandle() != nullptr, where, ": cannot be read: ", file.strError(), kTry);
  Check(file, where);
  Sound sound{.rate_hz = file.samplerate(), .samples = {}};
  const auto channels = static_cast<std::size_t>(file.channels());
  // What the file says of its length is not believed: it grows with what is there.
  std::vector<float> values(kFramesAtOnce * channels);
  for (;;) {
    const auto count = static_cast<std::size_t>(file.readf(values.data(), kFramesAtOnce));
    ACUS_REQUIRE(file.error() == 0, where, ": is damaged after ", sound.duration_s(),
                 " s: ", file.strError(), kTry);
    if (count == 0) break;
    for (std::size_t i = 0; i < count; ++i) {
      double sum = 0.0;
      for (std::size_t c = 0; c < channels; ++c) sum += values[i * channels + c];
      ACUS_REQUIRE(std::isfinite(sum), where, ": sample ", sound.samples.size(),
                   " is no finite number", kTry);
      sound.samples.push_back(SampleOf(sum / static_cast<double>(channels)));
    }
    ACUS_REQUIRE(sound.duration_s() <= kLongestSoundS, where, ": longer than the allowed ",
                 kLongestSoundS, " s", kTry);
  }
  ACUS_REQUIRE(!sound.samples.empty(), where, ": it has no sample", kTry);
  return sound;
}

void WriteWav(const fs::path& path, const Sound& sound) {
  AtomicFile out(path);
  const auto count = static_cast<sf_count_t>(sound.samples.size());
  {
    SndfileHandle file(out.path().string(), SFM_WRITE, SF_FORMAT_WAV | SF_FORMAT_PCM_16, 1,
                       sound.rate_hz);
    ACUS_REQUIRE(file.rawHandle() != nullptr && file.writef(sound.samples.data(), count) == count,
                 path.string(), ": cannot be written: ", file.strError());
  }
  out.Commit();
}

Sound TrackOf(const Sound& sound, const std::vector<double>& times_s, double duration_s) {
  const auto at = [&sound](double time_s) {
    return static_cast<std::size_t>(std::llround(std::max(0.0, time_s) * sound.rate_hz));
  };
  std::size_t count = at(duration_s);
  for (const double time_s : times_s) count = std::max(count, at(time_s) + sound.samples.size());
  Sound track{.rate_hz = sound.rate_hz, .samples = std::vector<std::int16_t>(count)};
  for (const double time_s : times_s) {
    for (std::size_t i = 0; i < sound.samples.size(); ++i) {
      std::int16_t& sample = track.samples[at(time_s) + i];
      sample = static_cast<std::int16_t>(std::clamp(sample + sound.samples[i], -32768, 32767));
    }
  }
  return track;
}

}  // namespace acus::sound
