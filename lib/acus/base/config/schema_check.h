// Holds a JSON document against a JSON Schema (draft 7, without oneOf/anyOf) and fills in defaults.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace acus::config {

/// All problems, each "/pointer: what is wrong, what is allowed, what was given". Empty if it fits.
std::vector<std::string> Problems(const nlohmann::json& schema, const nlohmann::json& document);

/// Adds every property that the schema gives a default and the document omits, also inside
/// objects and array items that are there. An object with default {} is filled recursively.
void FillDefaults(const nlohmann::json& schema, nlohmann::json& document);

}  // namespace acus::config
