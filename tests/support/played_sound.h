// Where a sound is in what was played, and OpenAL Soft that plays into a file.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/sound/sound.h"

namespace acus::testing_support {

/// From now on OpenAL Soft plays into this WAV file: to be called before the process has loaded it.
inline void PlayInto(const std::filesystem::path& wav) {
  auto settings = wav;
  settings.replace_extension(".conf");
  // Dither would be noise of one bit where there is silence.
  WriteTextFile(settings, Message("[general]\nsample-type = int16\nchannels = stereo\n"
                                  "frequency = 44100\ndither = false\n[wave]\nfile = ",
                                  wav.string(), "\n"));
  setenv("ALSOFT_DRIVERS", "wave", 1);
  setenv("ALSOFT_CONF", settings.c_str(), 1);
}

/// 1: the samples from `at` on are those of `sound`, times a factor.
inline double LikenessAt(const sound::Sound& played, std::size_t at, const sound::Sound& sound) {
  double both = 0.0;
  double a = 0.0;
  double b = 0.0;
  for (std::size_t i = 0; i < sound.samples.size() && at + i < played.samples.size(); ++i) {
    const double x = played.samples[at + i];
    const double y = sound.samples[i];
    both += x * y;
    a += x * x;
    b += y * y;
  }
  return a > 0.0 ? both / std::sqrt(a * b) : 0.0;
}

struct FoundSound {
  std::size_t at = 0;  ///< Its first sample.
  double likeness = 0.0;
};

/// Whatever is between silences of the length of `sound`, or follows it at once.
inline std::vector<FoundSound> FindSounds(const sound::Sound& played, const sound::Sound& sound) {
  std::vector<FoundSound> found;
  for (std::size_t at = 0; at + sound.samples.size() <= played.samples.size(); ++at) {
    if (played.samples[at] == 0) continue;
    // The first samples of a sound that begins softly are zeros.
    FoundSound best;
    for (std::size_t back = 0; back < 60 && back <= at; ++back) {
      const double likeness = LikenessAt(played, at - back, sound);
      if (likeness > best.likeness) best = {at - back, likeness};
    }
    found.push_back(best);
    at = std::max(at, best.at + sound.samples.size());
  }
  return found;
}

}  // namespace acus::testing_support
