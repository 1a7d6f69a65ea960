// The goal of the choice of a setting: a budget of time, or an accuracy.
#pragma once

#include <optional>
#include <string>

namespace acus::tuning {

enum class GoalKind {
  kBudget,    ///< The most accurate setting within the time.
  kAccuracy,  ///< The cheapest setting within the error.
};

/// Limits for the two parts of a simulation, forces and images. At least one of them is set.
struct Goal {
  GoalKind kind = GoalKind::kBudget;
  /// kBudget: CPU time of a force step, 99.9th percentile, us. kAccuracy: largest RMS error of the
  /// force, N.
  std::optional<double> force = std::nullopt;
  /// kBudget: CPU time of an image, 95th percentile, ms. kAccuracy: smallest PSNR, dB.
  std::optional<double> image = std::nullopt;
};

/// "force=0.5ms,image=16ms": one part or both, each once; us, ms or s.
/// @throws InputError naming the problem and what is allowed.
Goal ParseBudget(const std::string& text);

/// "force=0.02N,image=35dB": one part or both, each once; N or mN, and dB.
/// @throws InputError naming the problem and what is allowed.
Goal ParseAccuracy(const std::string& text);

/// "force=0.05N" alone, N. @throws InputError as ParseAccuracy, and if it names the image.
double ParseForceAccuracyN(const std::string& text);

/// The goal of a live session: a force step at `force_rate_hz`, an image at `image_rate_hz`.
/// @pre both > 0.
Goal LiveBudget(double force_rate_hz, double image_rate_hz);

/// In the format of ParseBudget or ParseAccuracy: "force=0.5ms,image=16ms". Nine digits, so that a
/// number typed by a user is reproduced.
std::string TextOf(const Goal& goal);

}  // namespace acus::tuning
