// The parameters of a simulation: values that make it coarser or finer, and what they affect.
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

/// A parameter of a scenario: the last of its values is the reference of errors. Its default_value
/// is the schema's, its scenario_value the current one; null if there is none.
struct Knob : effects::Knob {
  /// Its positions in the scenario (JSON pointers); empty: it is not in the scenario but affects
  /// how the session is stepped (step_rate_hz).
  std::vector<std::string> pointers;
  bool falls = false;  ///< Smaller numbers are more expensive: spacings.

  /// @pre values is not empty.
  const nlohmann::json& MostExpensive() const { return values.back(); }
  bool IsPapers(const nlohmann::json& value) const;
};

/// The parameters of the effects in `scenario`, each with its values.
/// @param recorded_rate_hz  Rate of the session's samples; 0: it has none, and no step_rate_hz.
std::vector<Knob> KnobsOf(const scenario::Scenario& scenario, double recorded_rate_hz);

/// @throws InputError listing the existing ones, with the most similar name.
const Knob& KnobNamed(std::span<const Knob> knobs, std::string_view name);

/// Parses a parameter from the user: "needle_nodes" with its values and the one of the scenario, or
/// "needle_nodes=15,50" with just these - with a single one, the scenario's as well - in order from
/// cheap to expensive. Words keep the order of the knob, folders that of the user.
/// @throws InputError for an unknown knob or word, a value of the wrong kind, or too few values.
Knob KnobFromText(std::span<const Knob> knobs, const std::string& text);

/// The changes of a scenario that set these parameters to `setting`. Parameters without a pointer
/// give none.
/// @throws InputError if the setting names a knob that is not among `knobs`.
std::vector<scenario::Override> OverridesOf(std::span<const Knob> knobs, const Setting& setting);

}  // namespace acus::tuning
