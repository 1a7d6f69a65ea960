#include "acus/data/sound/sound.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/bytes.h"
#include "acus/base/core/error.h"

namespace acus::sound {
namespace {

namespace fs = std::filesystem;

constexpr std::uint16_t kPcm = 1;
constexpr std::uint16_t kExtensible = 0xfffe;  // Says further on what it is.
constexpr std::size_t kFormatBytes = 16;

struct Format {
  std::uint16_t kind = 0;
  std::uint16_t channels = 0;
  std::uint32_t rate_hz = 0;
  std::uint16_t bits = 0;
};

Format FormatOf(std::span<const std::uint8_t> bytes) {
  core::ByteReader in(bytes, std::endian::little);
  Format format;
  format.kind = in.Number<std::uint16_t>();
  format.channels = in.Number<std::uint16_t>();
  format.rate_hz = in.Number<std::uint32_t>();
  in.Take(6);  // Bytes per second and per sample follow from the rest.
  format.bits = in.Number<std::uint16_t>();
  if (format.kind == kExtensible) {
    in.Take(8);
    format.kind = in.Number<std::uint16_t>();
  }
  return format;
}

void Check(const Format& format, const std::string& where) {
  constexpr const char* kTry = "; convert it, for example with ffmpeg -i IN -ac 1 -sample_fmt s16";
  ACUS_REQUIRE(format.kind == kPcm && format.bits == 16, where, ": format ", format.kind, " with ",
               format.bits, " bits; allowed is PCM (1) with 16 bits", kTry);
  ACUS_REQUIRE(format.channels == 1 || format.channels == 2, where, ": ", format.channels,
               " channels; allowed are 1 and 2", kTry);
  ACUS_REQUIRE(format.rate_hz >= kLeastRateHz && format.rate_hz <= kLargestRateHz, where, ": ",
               format.rate_hz, " samples per second; allowed are ", kLeastRateHz, " to ",
               kLargestRateHz, kTry);
}

Sound SoundOf(const Format& format, std::span<const std::uint8_t> data, const std::string& where) {
  const std::size_t count = data.size() / (2UL * format.channels);
  ACUS_REQUIRE(count > 0, where, ": it has no sample");
  ACUS_REQUIRE(static_cast<double>(count) <= kLongestSoundS * format.rate_hz, where, ": ",
               static_cast<double>(count) / format.rate_hz, " s long; allowed are ", kLongestSoundS,
               " s");
  Sound sound{.rate_hz = static_cast<int>(format.rate_hz),
              .samples = std::vector<std::int16_t>(count)};
  core::ByteReader in(data, std::endian::little);
  for (std::int16_t& sample : sound.samples) {
    int sum = 0;
    for (int channel = 0; channel < format.channels; ++channel) sum += in.Number<std::int16_t>();
    sample = static_cast<std::int16_t>(sum / format.channels);
  }
  return sound;
}

}  // namespace

Sound ReadWav(const fs::path& path) {
  const std::string where = path.string();
  const std::string text = ReadTextFile(path);
  core::ByteReader in(text, std::endian::little);
  const std::string riff = in.Text(4);
  in.Take(4);  // Size of all: the parts have their own.
  ACUS_REQUIRE(riff == "RIFF" && in.Text(4) == "WAVE", where, ": is no WAV file");
  std::optional<Format> format;
  while (in.left() >= 8) {
    const std::string name = in.Text(4);
    const std::size_t size = in.Number<std::uint32_t>();
    ACUS_REQUIRE(size <= in.left(), where, ": part '", name, "' should have ", size,
                 " bytes, but the file ends after ", in.left());
    const auto part = in.Take(size);
    if (name == "fmt ") {
      ACUS_REQUIRE(size >= kFormatBytes, where, ": part 'fmt ' has ", size, " bytes of ",
                   kFormatBytes);
      format = FormatOf(part);
      Check(*format, where);
    } else if (name == "data") {
      ACUS_REQUIRE(format, where, ": part 'data' comes before 'fmt '");
      return SoundOf(*format, part, where);
    }
    if (size % 2 == 1) in.Take(1);
  }
  throw InputError(where + ": has no part 'data'; was it cut off?");
}

void WriteWav(const fs::path& path, const Sound& sound) {
  core::ByteWriter out(std::endian::little);
  const auto data_bytes = static_cast<std::uint32_t>(2 * sound.samples.size());
  out.Text("RIFF", 4);
  out.Number(std::uint32_t{36 + data_bytes});
  out.Text("WAVEfmt ", 8);
  out.Number(static_cast<std::uint32_t>(kFormatBytes));
  out.Number(kPcm);
  out.Number(std::uint16_t{1});
  out.Number(static_cast<std::uint32_t>(sound.rate_hz));
  out.Number(static_cast<std::uint32_t>(2 * sound.rate_hz));
  out.Number(std::uint16_t{2});
  out.Number(std::uint16_t{16});
  out.Text("data", 4);
  out.Number(data_bytes);
  for (const std::int16_t sample : sound.samples) out.Number(sample);
  WriteTextFile(path, out.AsString());
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
