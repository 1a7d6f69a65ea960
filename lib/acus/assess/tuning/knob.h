// The knobs of fidelity: what can be simulated coarser or finer, and what that touches.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acus/assess/tuning/setting.h"
#include "acus/scene/effects/knob.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::tuning {

using effects::ActsOn;

/// "force", "image", "force and image"
std::string_view NameOf(ActsOn acts_on);

using effects::PaperValue;

/// A knob in a scenario: the last of its values is what errors are against. Its default_value is
/// the schema's, its scenario_value where it stands; null if there is none.
struct Knob : effects::Knob {
  /// Where the scenario has it (JSON pointers); empty: it is not in the scenario but in how the
  /// session is played (step_rate_hz).
  std::vector<std::string> pointers;
  bool falls = false;  ///< Smaller numbers are more expensive: spacings.

  /// @pre values is not empty.
  const nlohmann::json& MostExpensive() const { return values.back(); }
  bool IsPapers(const nlohmann::json& value) const;
};

/// The knobs that have something to turn in what `scenario` calls for, each with its values.
/// @param recorded_rate_hz  Of the session's samples; 0: it has none, and no step_rate_hz.
std::vector<Knob> KnobsOf(const scenario::Scenario& scenario, double recorded_rate_hz);

/// @throws InputError that lists the knobs there are, and says which one was meant perhaps.
const Knob& KnobNamed(std::span<const Knob> knobs, std::string_view name);

/// The knob as the user writes it: "needle_nodes" with its values and the one of the scenario, or
/// "needle_nodes=15,50" with just these - with a single one, the scenario's as well - in order
/// from cheap to expensive. Words keep the order of the knob, folders that of the user.
/// @throws InputError for an unknown knob or word, a value of the wrong kind, or too few values.
Knob KnobFromText(std::span<const Knob> knobs, const std::string& text);

/// The changes of a scenario that bring these knobs to `setting`. Knobs without a pointer give
/// none.
/// @throws InputError if the setting names a knob that is not among `knobs`.
std::vector<scenario::Override> OverridesOf(std::span<const Knob> knobs, const Setting& setting);

}  // namespace acus::tuning
