#include "acus/base/config/json_file.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include "acus/base/config/schema_check.h"
#include "acus/base/config/schemas.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/base/core/spelling.h"

namespace acus::config {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Refuses a key that is given twice in one object: the parser alone would keep the last one.
class DuplicateKeys {
 public:
  bool operator()(int /*depth*/, json::parse_event_t event, json& parsed) {
    switch (event) {
      case json::parse_event_t::object_start:
        keys_.emplace_back();
        break;
      case json::parse_event_t::object_end:
        keys_.pop_back();
        break;
      case json::parse_event_t::key:
        if (!keys_.back().insert(parsed.get<std::string>()).second && first_.empty()) {
          first_ = parsed.get<std::string>();
        }
        break;
      default:
        break;
    }
    return true;
  }
  const std::string& first() const { return first_; }

 private:
  std::vector<std::set<std::string>> keys_;
  std::string first_;
};

void RequireFinite(const json& node, const std::string& pointer) {
  if (node.is_number_float()) {
    ACUS_REQUIRE(std::isfinite(node.get<double>()), pointer,
                 ": a number to be written is not finite");
  }
  if (node.is_structured()) {
    for (const auto& [key, child] : node.items()) RequireFinite(child, pointer + "/" + key);
  }
}

}  // namespace

json ReadJson(const fs::path& path) {
  const std::string text = ReadTextFile(path);
  RequireJsonDepth(text, path.string());
  DuplicateKeys duplicates;
  json document;
  try {
    document = json::parse(text, std::ref(duplicates), /*allow_exceptions=*/true,
                           /*ignore_comments=*/true);
  } catch (const json::exception& error) {
    std::string what = error.what();
    what.erase(0, what.find("] ") == what.npos ? 0 : what.find("] ") + 2);
    throw InputError(Message(path.string(), ": is not valid JSON: ", what));
  }
  ACUS_REQUIRE(duplicates.first().empty(), path.string(), ": key '", duplicates.first(),
               "' is given twice in one object; remove one of them");
  return document;
}

json ReadConfig(const fs::path& path, std::string_view schema_name) {
  return CheckedConfig(ReadJson(path), schema_name, path.string());
}

json CheckedConfig(json document, std::string_view schema_name, const std::string& label) {
  return CheckedConfig(std::move(document), schema_name, label,
                       json::parse(SchemaText(schema_name)));
}

json CheckedConfig(json document, std::string_view schema_name, const std::string& label,
                   const json& schema) {
  const std::string format = Message(schema_name, "/1");
  ACUS_REQUIRE(document.is_object(), label,
               ": is not a JSON object; see docs/reference/formats.md");
  ACUS_REQUIRE(document.contains("format") && document["format"] == format, label,
               ": /format: must be \"", format, "\", got ",
               document.contains("format") ? document["format"].dump() : "nothing",
               "; is it another kind of file?");
  const auto problems = Problems(schema, document);
  if (!problems.empty()) {
    std::string text = label + ": does not fit its schema:";
    for (const std::string& problem : problems) text += "\n  " + problem;
    throw InputError(text);
  }
  FillDefaults(schema, document);
  return document;
}

void WriteJson(const fs::path& path, const json& document) {
  RequireFinite(document, path.string() + ": ");
  // Names of files and points may hold bytes that are not UTF-8; JSON may not.
  WriteTextFile(path, document.dump(2, ' ', false, json::error_handler_t::replace) + "\n");
}

std::vector<std::string> SchemaNames() {
  std::vector<std::string> names;
  for (const EmbeddedSchema& schema : EmbeddedSchemas()) names.emplace_back(schema.name);
  std::ranges::sort(names);
  return names;
}

std::string_view SchemaText(std::string_view schema_name) {
  for (const EmbeddedSchema& schema : EmbeddedSchemas()) {
    if (schema.name == schema_name) return schema.text;
  }
  throw InputError(Message("no schema is named '", schema_name, "'"));
}

fs::path ConfigsFolder() {
  if (const char* folder = std::getenv("ACUS_CONFIGS")) return folder;
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  return program.parent_path().parent_path() / "share" / "acus" / "configs";
}

namespace {

/// All presets, as their path below the presets; those of one folder, if the name has one that is
/// there.
std::vector<fs::path> PresetsLike(const fs::path& name) {
  std::vector<fs::path> presets;
  std::error_code failed;
  const fs::path folder = ConfigsFolder() / name.parent_path();
  const bool has_folder =
      name.is_relative() && name.has_parent_path() && fs::exists(folder, failed);
  fs::recursive_directory_iterator entries(has_folder ? folder : ConfigsFolder(), failed);
  for (; !failed && entries != fs::recursive_directory_iterator(); entries.increment(failed)) {
    if (entries->path().extension() != ".json") continue;
    presets.push_back(entries->path().lexically_relative(ConfigsFolder()));
  }
  std::ranges::sort(presets);
  return presets;
}

/// "; did you mean scenarios/liver_biopsy.json?": the presets of that name, or of nearly that name.
std::string PresetHint(const fs::path& name) {
  const std::vector<fs::path> presets = PresetsLike(name);
  std::vector<std::string> names;
  for (const fs::path& preset : presets) names.push_back(preset.stem().string());
  const auto nearest = NearestSpelling(name.stem().string(), names);
  std::string meant;
  for (std::size_t n = 0; nearest && n < presets.size(); ++n) {
    if (names[n] == *nearest) meant += (meant.empty() ? "" : " or ") + presets[n].generic_string();
  }
  return meant.empty() ? "" : Message("; did you mean ", meant, "?");
}

}  // namespace

fs::path FindConfig(const fs::path& name, const fs::path& relative_to) {
  const fs::path near = name.is_absolute() ? name : relative_to / name;
  std::error_code ignored;
  // A loop of links is there, too: reading it says what is wrong with it.
  const auto is_there = [&ignored](const fs::path& path) {
    return fs::symlink_status(path, ignored).type() == fs::file_type::symlink
               ? fs::status(path, ignored).type() != fs::file_type::not_found
               : fs::exists(path, ignored);
  };
  if (is_there(near)) return near;
  const fs::path installed = ConfigsFolder() / name;
  if (!name.is_absolute() && is_there(installed)) return installed;
  // A change on the command line (--set) is reported as seen from there.
  const fs::path here = fs::current_path(ignored) / name;
  if (is_there(here)) return here;
  throw InputError(Message(name.string(), ": no such file; tried ", near.string(), ", ",
                           installed.string(), " and ", here.string(), PresetHint(name)));
}

}  // namespace acus::config
