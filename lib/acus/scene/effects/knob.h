// Knobs of fidelity: settings of an effect that can be coarser or finer.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace acus::effects {

/// What a change of a setting acts on.
enum class ActsOn { kForce, kImage, kBoth };

/// What a paper did.
struct PaperValue {
  nlohmann::json value;
  std::string source;  ///< "Fortmeier-2016, section 3.5"
};

/// A setting that can be coarser or finer, as its effect declares it.
struct Knob {
  std::string name;       ///< As in --knob, with its unit: "contact_spacing_mm".
  std::string title;      ///< "points along a vessel"
  std::string unit = {};  ///< Empty for a pure number.
  /// Path below the effect's settings: "fe_2d/spacing_mm"; with a leading '/', in the scenario.
  std::string key;
  ActsOn acts_on = ActsOn::kBoth;
  /// From cheap to expensive. Empty: there are none unless the user names them (folders).
  std::vector<nlohmann::json> values = {};
  std::vector<PaperValue> papers = {};
  bool is_folder = false;              ///< Values are folders, from the working folder.
  nlohmann::json default_value = {};   ///< Null: as the schema says.
  nlohmann::json scenario_value = {};  ///< Null: as the text of the scenario says.
};

}  // namespace acus::effects
