// The setting for a goal: predicted from knobs turned one at a time, then measured jointly.
//
// Turned one at a time, the knobs give a model in which costs add up, and so do squared errors
// (the errors of different models are not correlated):
//   cost(setting) = cost(given) + sum over knobs of [cost(that knob turned alone) - cost(given)].
// In it the best joint setting is found exactly. The model is wrong where knobs multiply - twice
// the samples on twice the lines - so the best setting is measured, the model is corrected by what
// was found (around that setting, and by multiplying instead of adding where that explains more),
// and the next best is measured, until the best has been measured itself. The answer is the best of
// those that were measured; a prediction alone is never the answer.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "acus/assess/tuning/goal.h"

namespace acus::tuning {

/// A knob as the choice sees it.
struct ChoiceKnob {
  std::string name;
  int num_values = 1;
  int given = 0;  ///< Index of the value that the scenario was given with.
  bool acts_on_force = false;
  bool acts_on_image = false;
};

/// Of each knob, in their order: which of its values.
using ValueIndices = std::vector<int>;

/// What a setting was measured to cost, and how far off it is. NaN: the scene has no such part.
struct Outcome {
  double step_us = std::numeric_limits<double>::quiet_NaN();         ///< 99.9th percentile.
  double image_ms = std::numeric_limits<double>::quiet_NaN();        ///< 95th percentile.
  double force_error_n = std::numeric_limits<double>::quiet_NaN();   ///< RMS, N.
  double image_error_db = std::numeric_limits<double>::quiet_NaN();  ///< PSNR; infinity: the same.
  bool usable = true;  ///< False: it must not be chosen, whatever it costs.
};

struct Candidate {
  ValueIndices indices;
  Outcome measured;
  Outcome predicted;  ///< By the additive model alone.
};

struct ChoiceSettings {
  int most_joint = 24;  ///< At most so many settings are measured after the one-at-a-time ones.
  /// A knob whose cost differs from the given setting's by less than this share of it costs the
  /// same: times are noisy, and a knob should not be turned for noise.
  double noise = 0.05;
  /// If the given setting meets the goal, it is chosen, and no other one is measured.
  bool keep_given = false;
};

struct Choice {
  std::vector<Candidate> measured;    ///< All, in the order in which they were measured.
  std::optional<std::size_t> chosen;  ///< In `measured`; nothing if none meets the goal.
  /// In `measured`: the one that comes nearest to the goal - of a budget the cheapest, of an
  /// accuracy the most accurate.
  std::size_t nearest = 0;
  int num_one_at_a_time = 0;  ///< How many of `measured` came first, the given setting included.
};

/// Knobs that only act on a part that the goal does not name stay as given. Of settings that meet a
/// budget for both parts, the one with the smallest sum of squared errors is best, each over the
/// largest that any knob alone gives; of those that meet an accuracy, the one with the smallest sum
/// of costs, each over that of the given setting.
/// @param measure  Called once per setting. Its outcome is taken as it is.
/// @throws InputError if the goal names a part that the scene does not have.
Choice ChooseSetting(const std::vector<ChoiceKnob>& knobs, const Goal& goal,
                     const ChoiceSettings& settings,
                     const std::function<Outcome(const ValueIndices&)>& measure);

/// True if the outcome keeps to every limit that the goal names.
bool Meets(const Outcome& outcome, const Goal& goal);

}  // namespace acus::tuning
