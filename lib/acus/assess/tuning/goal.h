// What a setting is chosen for: a budget of time, or an accuracy.
#pragma once

#include <optional>
#include <string>

namespace acus::tuning {

enum class GoalKind {
  kBudget,    ///< The most accurate setting that takes at most so long.
  kAccuracy,  ///< The cheapest setting that is off by at most so much.
};

/// Of the two parts of a simulation - forces and images - those that are named are held to their
/// limit. At least one is.
struct Goal {
  GoalKind kind = GoalKind::kBudget;
  /// kBudget: CPU time of a force step, 99.9th percentile, us. kAccuracy: largest RMS error of the
  /// force, N.
  std::optional<double> force = std::nullopt;
  /// kBudget: CPU time of an image, 95th percentile, ms. kAccuracy: smallest PSNR, dB.
  std::optional<double> image = std::nullopt;
};

/// "force=0.5ms,image=16ms": one part or both, each once; us, ms or s.
/// @throws InputError that says what is wrong and what is allowed.
Goal ParseBudget(const std::string& text);

/// "force=0.02N,image=35dB": one part or both, each once; N or mN, and dB.
/// @throws InputError that says what is wrong and what is allowed.
Goal ParseAccuracy(const std::string& text);

/// "force=0.05N" alone, N. @throws InputError as ParseAccuracy, and if it names the image.
double ParseForceAccuracyN(const std::string& text);

/// What a live session needs: a force step at `force_rate_hz`, an image at `image_rate_hz`.
/// @pre both > 0.
Goal LiveBudget(double force_rate_hz, double image_rate_hz);

/// As ParseBudget or ParseAccuracy read it: "force=0.5ms,image=16ms". Nine digits: what
/// a person typed comes back as typed.
std::string TextOf(const Goal& goal);

}  // namespace acus::tuning
