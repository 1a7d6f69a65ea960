// Strict JSON files: every problem at once, as "file: /pointer: what is wrong, what is allowed".
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace acus::config {

/// Parses a JSON file. Comments are allowed, duplicate keys are not.
/// @throws InputError with file, line and column of a syntax error.
nlohmann::json ReadJson(const std::filesystem::path& path);

/// Reads a file whose top-level "format" is `schema_name` + "/1", holds it against the schema
/// configs/schema/<schema_name>.schema.json (embedded in the program) and fills in the schema's
/// defaults, so that callers read every key with `.at()`: defaults live in the schema only.
/// @throws InputError listing all problems: unknown keys (with the nearest known one), wrong types,
///     values out of range, missing keys.
nlohmann::json ReadConfig(const std::filesystem::path& path, std::string_view schema_name);

/// The same for a document in memory; `label` stands for the file name in messages.
nlohmann::json CheckedConfig(nlohmann::json document, std::string_view schema_name,
                             const std::string& label);

/// The same with a schema that has been added to.
nlohmann::json CheckedConfig(nlohmann::json document, std::string_view schema_name,
                             const std::string& label, const nlohmann::json& schema);

/// Writes with two-space indentation, atomically. @throws InputError if a number is not finite.
void WriteJson(const std::filesystem::path& path, const nlohmann::json& document);

/// Names of all embedded schemas, sorted.
std::vector<std::string> SchemaNames();

/// The text of an embedded schema. @throws InputError if there is none of that name.
std::string_view SchemaText(std::string_view schema_name);

/// Finds a preset such as "tissues/default.json": first as a path relative to `relative_to` (a
/// folder), then in the installed or built configs folder, then relative to the working folder.
/// @throws InputError naming every place that was tried.
std::filesystem::path FindConfig(const std::filesystem::path& name,
                                 const std::filesystem::path& relative_to);

/// The configs folder of this installation: $ACUS_CONFIGS, or ../share/acus/configs beside the
/// folder of the running program.
std::filesystem::path ConfigsFolder();

}  // namespace acus::config
