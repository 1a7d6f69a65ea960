#include "acus/base/core/random.h"

#include <cmath>
#include <numbers>

namespace acus {
namespace {

constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15ULL;

std::uint64_t Mix(std::uint64_t x) {
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::string_view name, std::uint64_t index)
    : state_(Mix(seed + kGolden)) {
  for (const char c : name) state_ = Mix(state_ ^ static_cast<unsigned char>(c)) + kGolden;
  state_ = Mix(state_ ^ Mix(index + kGolden));
}

std::uint64_t RandomStream::Next() {
  state_ += kGolden;
  return Mix(state_);
}

double RandomStream::Uniform() {
  return static_cast<double>(Next() >> 11U) * 0x1.0p-53;
}

double RandomStream::Uniform(double low, double high) {
  return low + (high - low) * Uniform();
}

double RandomStream::Normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
  const double angle = 2.0 * std::numbers::pi * Uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

}  // namespace acus
