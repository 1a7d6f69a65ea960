// The setting for a goal: predicted from parameters varied one at a time, then measured jointly.
//
// Varied one at a time, the parameters give a model in which costs add up, and so do squared errors
// (the errors of different models are not correlated):
//   cost(setting) = cost(given) + sum over knobs of [cost(that knob changed alone) - cost(given)].
// Its best joint setting is found exactly. The model is wrong where parameters multiply - twice the
// samples on twice the lines - so the best setting is measured, the model is corrected by the
// result (around that setting, and by multiplying instead of adding where that explains more), and
// the next best is measured, until the best has been measured itself. The answer is the best
// measured setting; a prediction alone is never the answer.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "acus/assess/tuning/goal.h"

namespace acus::tuning {

/// A parameter and its values for the choice.
struct ChoiceKnob {
  std::string name;
  int num_values = 1;
  int given = 0;  ///< Index of the scenario's value.
  bool acts_on_force = false;
  bool acts_on_image = false;
};

/// Index of the value of each parameter, in their order.
using ValueIndices = std::vector<int>;

/// Measured cost and error of a setting. NaN: the scene has no such part.
struct Outcome {
  double step_us = std::numeric_limits<double>::quiet_NaN();         ///< 99.9th percentile.
  double image_ms = std::numeric_limits<double>::quiet_NaN();        ///< 95th percentile.
  double force_error_n = std::numeric_limits<double>::quiet_NaN();   ///< RMS, N.
  double image_error_db = std::numeric_limits<double>::quiet_NaN();  ///< PSNR; infinity: identical.
  bool usable = true;  ///< False: it must not be chosen.
};

struct Candidate {
  ValueIndices indices;
  Outcome measured;
  Outcome predicted;  ///< By the additive model alone.
};

struct ChoiceSettings {
  int most_joint = 24;  ///< Most settings measured after the one-at-a-time ones.
  /// A parameter whose cost differs from the given setting's by less than this share costs the
  /// same: times are noisy, and noise must not decide.
  double noise = 0.05;
  /// If the given setting meets the goal, it is chosen, and no other one is measured.
  bool keep_given = false;
};

struct Choice {
  std::vector<Candidate> measured;    ///< All, in the order of measurement.
  std::optional<std::size_t> chosen;  ///< Index in `measured`; nothing if none meets the goal.
  /// Index in `measured` of the one closest to the goal: for a budget the cheapest, for an accuracy
  /// the most accurate.
  std::size_t nearest = 0;
  int num_one_at_a_time = 0;  ///< Their number in `measured`, including the given setting.
};

/// Parameters that only affect a part that the goal does not name keep the scenario's values. Of
/// settings that meet a budget for both parts, the one with the smallest sum of squared errors is
/// best, each relative to the largest of any parameter alone; of those that meet an accuracy, the
/// one with the smallest sum of costs, each relative to that of the given setting.
/// @param measure  Called once per setting. Its result is used unchanged.
/// @throws InputError if the goal names a part that the scene does not have.
Choice ChooseSetting(const std::vector<ChoiceKnob>& knobs, const Goal& goal,
                     const ChoiceSettings& settings,
                     const std::function<Outcome(const ValueIndices&)>& measure);

/// True if the outcome meets every limit that the goal names.
bool Meets(const Outcome& outcome, const Goal& goal);

}  // namespace acus::tuning
