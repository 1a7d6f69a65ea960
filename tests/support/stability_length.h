// How long hard cases run: short by default, so that they run with all other tests, and as long as
// developer/stability --full asks for.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace acus::testing_support {

inline double StabilityNumber(const char* variable, double otherwise) {
  const char* text = std::getenv(variable);
  return text == nullptr || *text == '\0' ? otherwise : std::atof(text);
}

/// Random steps through a model: ACUS_STABILITY_STEPS, but never fewer than `least`.
inline int StabilitySteps(int least) {
  const double asked = StabilityNumber("ACUS_STABILITY_STEPS", 0.0);
  return asked > least && asked < 1e9 ? static_cast<int>(asked) : least;
}

/// Simulated seconds of a session: ACUS_STABILITY_SESSION_SECONDS, but never fewer than `least`.
inline double StabilitySessionSeconds(double least) {
  const double asked = StabilityNumber("ACUS_STABILITY_SESSION_SECONDS", 0.0);
  return asked > least ? asked : least;
}

/// Seconds on the clock for what goes on until it is told to stop: ACUS_STABILITY_SECONDS.
inline double StabilitySeconds() {
  return StabilityNumber("ACUS_STABILITY_SECONDS", 0.0);
}

/// ACUS_STABILITY_SEED, 1 by default.
inline std::uint64_t StabilitySeed() {
  const char* text = std::getenv("ACUS_STABILITY_SEED");
  return text == nullptr || *text == '\0' ? 1 : std::strtoull(text, nullptr, 10);
}

}  // namespace acus::testing_support
