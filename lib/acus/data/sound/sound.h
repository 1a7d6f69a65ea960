// A sound, and its file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace acus::sound {

/// One channel. 32767 is full scale.
struct Sound {
  int rate_hz = 44100;  ///< Samples per second.
  std::vector<std::int16_t> samples;

  double duration_s() const {
    return static_cast<double>(samples.size()) / static_cast<double>(rate_hz);
  }
};

inline constexpr int kLeastRateHz = 8000;
inline constexpr int kLargestRateHz = 192000;
inline constexpr double kLongestSoundS = 60.0;  ///< Of a file that is read.

/// Reads WAV, AIFF, FLAC and Ogg, whatever the name says. 2 channels become their mean; values
/// beyond full scale are clipped. A file that was cut off may be read as far as it goes.
/// @throws InputError for anything else: another format, more channels, a rate that is not allowed,
///     no sample, a value that is not finite, more than kLongestSoundS, damage that the decoder
///     sees.
Sound ReadSound(const std::filesystem::path& path);

/// PCM of 16 bits. The same bytes for the same sound.
/// @throws InputError if the file cannot be written.
void WriteWav(const std::filesystem::path& path, const Sound& sound);

/// `sound` at these times (s, from the start of the track), all at the same volume; where two
/// overlap, they add up within full scale. The track is at least `duration_s` long.
Sound TrackOf(const Sound& sound, const std::vector<double>& times_s, double duration_s);

}  // namespace acus::sound
