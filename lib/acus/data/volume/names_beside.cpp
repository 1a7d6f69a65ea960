#include "acus/data/volume/names_beside.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"
#include "acus/data/volume/label_table.h"
#include "acus/data/volume/scalar_file.h"
#include "acus/data/volume/terminology.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::string_view kStackEnding = ".mitklabel.json";

void AddName(std::int32_t value, const std::string& text, const fs::path& file, ValueNames& names) {
  AddValueName(value, {.text = text, .codes = {}}, file.string(), names);
}

[[noreturn]] void RefuseLabels(const fs::path& file, const std::string& what) {
  throw InputError(Message(file.string(), ": ", what,
                           "; give each value one name, as {\"labels\": {\"1\": \"spleen\"}}, in "
                           "a file for --mapping"));
}

/// A list of objects with value and name. Empty if it is something else.
ValueNames NamesInList(const json& list, const fs::path& file) {
  ValueNames names;
  for (const json& entry : list) {
    if (entry.is_string()) RefuseLabels(file, "its labels are a list of names without values");
    if (!entry.is_object() || !entry.contains("name") || !entry.at("name").is_string()) return {};
    constexpr std::array kKeys = {"value", "id", "index", "label"};
    const auto key = std::ranges::find_if(kKeys, [&](const char* k) { return entry.contains(k); });
    if (key == kKeys.end() || !entry.at(*key).is_number_integer()) return {};
    AddName(entry.at(*key).get<std::int32_t>(), entry.at("name"), file, names);
  }
  return names;
}

/// {"1": "spleen"}, {"spleen": 1} or {"1": {"name": "spleen"}}; empty if it is something else.
ValueNames NamesIn(const json& object, const fs::path& file) {
  ValueNames names;
  if (object.is_array()) return NamesInList(object, file);
  if (!object.is_object()) return names;
  for (const auto& [key, entry] : object.items()) {
    const auto value = ParseNumber<std::int32_t>(key);
    const bool has_name =
        entry.is_object() && entry.contains("name") && entry.at("name").is_string();
    if (value && (entry.is_string() || has_name)) {
      AddName(*value, has_name ? entry.at("name") : entry, file, names);
    } else if (entry.is_number_integer()) {
      AddName(entry.get<std::int32_t>(), key, file, names);
    } else {
      return {};
    }
  }
  return names;
}

/// The labels of nnU-Net, which may be regions of several values.
ValueNames NamesOfLabels(const json& labels, const fs::path& file) {
  for (const auto& [key, entry] : labels.items()) {
    if (labels.is_object() && entry.is_array()) {
      RefuseLabels(file, Message("'", key, "' is a region of the values ", entry.dump()));
    }
  }
  return NamesIn(labels, file);
}

/// The segments of dcmqi's description: a list for each file, of segments with their codes.
ValueNames NamesOfSegments(const json& lists, const fs::path& file) {
  ValueNames names;
  for (const json& list : lists) {
    if (!list.is_array()) return {};
    for (const json& segment : list) {
      if (!segment.is_object() || !segment.contains("labelID")) return {};
      const json& id = segment.at("labelID");
      ACUS_REQUIRE(id.is_number_integer(), file.string(), ": labelID ", id.dump(),
                   " is not an integer");
      const auto code = [&](const char* key) {
        const json entry = segment.value(key, json::object());
        return entry.is_object() ? entry.value("CodeValue", "") : std::string();
      };
      ValueName name{.text = segment.value("SegmentLabel", segment.value("SegmentDescription", "")),
                     .codes = {}};
      for (const char* key : {"SegmentedPropertyTypeCodeSequence", "AnatomicRegionSequence"}) {
        if (const std::string value = code(key); !value.empty()) name.codes.push_back(value);
      }
      for (const char* key :
           {"SegmentedPropertyTypeModifierCodeSequence", "AnatomicRegionModifierSequence"}) {
        const std::string side = SideOfCode(code(key));
        if (!side.empty()) name.side = side;
      }
      AddValueName(id.get<std::int32_t>(), std::move(name), file.string(), names);
    }
  }
  return names;
}

/// The labels of an MITK stack that an image holds: of its group, or a mask of one label.
/// @param image  Name of its file; empty: of all groups.
ValueNames NamesOfStack(const json& stack, const std::string& image, const fs::path& file) {
  const auto is_image = [&](const json& node) {
    const fs::path named = node.value("_file", "");
    return image.empty() || named.filename() == image;
  };
  ValueNames names;
  for (const json& group : stack.at("groups")) {
    for (const json& label : group.at("labels")) {
      if (!is_image(group) && !is_image(label)) continue;
      const auto value = label.at("value").get<std::int32_t>();
      const bool is_own = !image.empty() && is_image(label);
      AddName(is_own ? label.value("_file_value", value) : value, label.at("name"), file, names);
    }
  }
  return names;
}

ValueNames NamesOfDocument(const json& document, const fs::path& file) {
  static const json::json_pointer kChannels("/network_data_format/outputs/pred/channel_def");
  if (document.is_array()) return NamesInList(document, file);
  if (!document.is_object()) return {};
  if (document.contains(kChannels)) return NamesIn(document.at(kChannels), file);
  if (document.contains("segmentAttributes") && document.at("segmentAttributes").is_array()) {
    return NamesOfSegments(document.at("segmentAttributes"), file);
  }
  if (document.contains("groups") && document.contains("type")) {
    return NamesOfStack(document, "", file);
  }
  return document.contains("labels") ? NamesOfLabels(document.at("labels"), file)
                                     : NamesIn(document, file);
}

template <typename Names>
ValueNames NamesInJson(const fs::path& file, const Names& names_of) {
  try {
    return names_of(config::ReadJson(file));
  } catch (const json::exception&) {
    throw InputError(Message(file.string(),
                             ": names the values of a label map in a form that is not read; "
                             "{\"labels\": {\"1\": \"spleen\"}} is"));
  }
}

/// Where names of a map may be, those that are nearest to it first.
std::vector<fs::path> CandidatesFor(const fs::path& label_map) {
  const fs::path folder = label_map.parent_path();
  const std::string stem = VolumeStem(label_map);
  std::vector<fs::path> files;
  for (const char* ending :
       {".tsv", ".csv", ".txt", ".label", ".lut", ".ctbl", "_ColorTable.ctbl", "_ColorTable.csv"}) {
    files.push_back(folder / (stem + ending));
  }
  if (stem.ends_with("dseg")) files.push_back(folder / "dseg.tsv");
  files.push_back(folder / (stem + ".json"));
  for (const fs::path& place : {folder, folder / ".."}) {
    for (const char* name : {"dataset.json", "metadata.json"}) files.push_back(place / name);
  }
  files.push_back(folder / "labels.txt");
  return files;
}

/// The stack of MITK in the map's folder that has it as image.
NamesBeside FindStack(const fs::path& label_map) {
  std::vector<fs::path> stacks;
  std::error_code error;
  const fs::path folder = label_map.has_parent_path() ? label_map.parent_path() : ".";
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().string().ends_with(kStackEnding)) stacks.push_back(entry.path());
  }
  std::ranges::sort(stacks);
  for (const fs::path& stack : stacks) {
    ValueNames names = NamesInJson(stack, [&](const json& document) {
      return NamesOfStack(document, label_map.filename().string(), stack);
    });
    if (!names.empty()) return {std::move(names), stack};
  }
  return {};
}

}  // namespace

ValueNames NamesInFile(const fs::path& file) {
  if (file.extension() != ".json") return NamesInTable(file);
  return NamesInJson(file, [&](const json& document) { return NamesOfDocument(document, file); });
}

NamesBeside FindNamesBeside(const fs::path& label_map) {
  for (const fs::path& candidate : CandidatesFor(label_map)) {
    std::error_code error;
    if (!fs::is_regular_file(candidate, error)) continue;
    ValueNames names = NamesInFile(candidate);
    if (!names.empty()) return {std::move(names), candidate.lexically_normal()};
  }
  return FindStack(label_map);
}

}  // namespace acus::volume
