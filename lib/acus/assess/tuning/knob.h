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

/// A knob in a scenario.
struct Knob {
  std::string name;   ///< As in --knob, with its unit: "contact_spacing_mm".
  std::string title;  ///< "nodes of the bendable needle"
  std::string unit;   ///< "mm", "Hz"; empty: a number, a word, a truth value.
  /// Where the scenario has it (JSON pointers); empty: it is not in the scenario but in how the
  /// session is played (step_rate_hz).
  std::vector<std::string> pointers;
  ActsOn acts_on = ActsOn::kForce;
  /// From cheap to expensive; the last one is what errors are against. Empty: there are none unless
  /// the user names them (folders).
  std::vector<nlohmann::json> values;
  bool falls = false;             ///< Smaller numbers are more expensive: spacings.
  bool is_folder = false;         ///< Values are folders, from the working folder.
  nlohmann::json default_value;   ///< Ours, from the schema; null if there is none.
  nlohmann::json scenario_value;  ///< Where it stands in this scenario; null if it is not known.
  std::vector<PaperValue> papers;

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
