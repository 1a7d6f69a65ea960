// A sound, and its WAV file.
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

/// Reads PCM of 16 bits with 1 or 2 channels, which become their mean.
/// @throws InputError for anything else: another format, a rate that is not allowed, no sample,
/// more
///     than kLongestSoundS, sizes that the file does not hold.
Sound ReadWav(const std::filesystem::path& path);

/// @throws InputError if the file cannot be written.
void WriteWav(const std::filesystem::path& path, const Sound& sound);

/// `sound` at these times (s, from the start of the track), all at the same volume; where two
/// overlap, they add up within full scale. The track is at least `duration_s` long.
Sound TrackOf(const Sound& sound, const std::vector<double>& times_s, double duration_s);

}  // namespace acus::sound
