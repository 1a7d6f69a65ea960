// A setting: the values of the parameters.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace acus::tuning {

/// Values of parameters by name: numbers, words, truth values, or paths. A parameter that is not
/// named has the scenario's value.
using Setting = std::map<std::string, nlohmann::json>;

/// A value as text for users: "15", "0.5", "on", "fe_3d".
std::string ValueText(const nlohmann::json& value);

/// Parses a value from the user: JSON ("on" and "off" are truth values), or else a word.
nlohmann::json ValueFromText(std::string_view text);

/// "needle_nodes=15, step_rate_hz=1000"
std::string TextOf(const Setting& setting);

/// True if two values are the same: 2 and 2.0 are.
bool SameValue(const nlohmann::json& a, const nlohmann::json& b);

}  // namespace acus::tuning
