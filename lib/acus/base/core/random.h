// Random numbers keyed by what is drawn, never by thread or order of calls elsewhere.
#pragma once

#include <cstdint>
#include <string_view>

namespace acus {

/// A stream that depends only on (seed, name, index): "the tremor of session 3", "voxel noise of
/// slice 17". SplitMix64 (Steele, Lea & Flood 2014), so that any compiler draws the same numbers.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::string_view name, std::uint64_t index = 0);

  std::uint64_t Next();
  double Uniform();                         ///< In [0, 1).
  double Uniform(double low, double high);  ///< In [low, high).
  double Normal();                          ///< Mean 0, standard deviation 1 (Box-Muller).

 private:
  std::uint64_t state_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace acus
