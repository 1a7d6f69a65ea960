// Knobs of fidelity: settings of an effect that can be coarser or finer.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace acus::effects {

/// The results that a change of a setting affects.
enum class ActsOn { kForce, kImage, kBoth };

/// The value that a paper used.
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
  /// From cheap to expensive. Empty: the user names them (folders).
  std::vector<nlohmann::json> values = {};
  std::vector<PaperValue> papers = {};
  bool is_folder = false;              ///< Values are folders, relative to the working folder.
  nlohmann::json default_value = {};   ///< Null: the default of the schema.
  nlohmann::json scenario_value = {};  ///< Null: the value in the scenario's file.
};

}  // namespace acus::effects
