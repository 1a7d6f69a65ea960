#include "acus/patient/segmentation/voxels/label_json.h"

#include <cmath>
#include <optional>
#include <vector>

#include "acus/base/config/json_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"
#include "acus/data/volume/scalar_file.h"
#include "acus/data/volume/terminology.h"

namespace acus::segmentation {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

void AddName(std::int32_t value, const std::string& text, const fs::path& file,
             volume::ValueNames& names) {
  if (value == 0) return;  // The background.
  const auto [place, is_new] =
      names.try_emplace(value, volume::ValueName{.text = text, .codes = {}});
  ACUS_REQUIRE(is_new, file.string(), ": value ", value, " is '", place->second.text, "' and '",
               text, "'; a value needs one name");
}

/// {"1": "spleen"} or {"spleen": 1}; empty if the object is something else.
volume::ValueNames NamesIn(const json& object, const fs::path& file) {
  volume::ValueNames names;
  if (!object.is_object()) return names;
  for (const auto& [key, entry] : object.items()) {
    if (entry.is_string()) {
      const auto value = ParseNumber<std::int32_t>(key);
      if (!value) return {};
      AddName(*value, entry.get<std::string>(), file, names);
    } else if (entry.is_number_integer()) {
      AddName(entry.get<std::int32_t>(), key, file, names);
    } else {
      return {};
    }
  }
  return names;
}

/// The segments of dcmqi's description: a list for each file, of segments with their codes.
volume::ValueNames NamesOfSegments(const json& lists, const fs::path& file) {
  volume::ValueNames names;
  for (const json& list : lists) {
    if (!list.is_array()) return {};
    for (const json& segment : list) {
      if (!segment.is_object() || !segment.contains("labelID")) return {};
      const json& id = segment.at("labelID");
      ACUS_REQUIRE(id.is_number_integer(), file.string(), ": labelID ", id.dump(),
                   " is not an integer");
      const auto text = segment.value("SegmentLabel", segment.value("SegmentDescription", ""));
      AddName(id.get<std::int32_t>(), text, file, names);
      const auto code = [&](const char* key) {
        const json entry = segment.value(key, json::object());
        return entry.is_object() ? entry.value("CodeValue", "") : std::string();
      };
      if (id.get<std::int32_t>() == 0) continue;
      volume::ValueName& name = names.at(id.get<std::int32_t>());
      for (const char* key : {"SegmentedPropertyTypeCodeSequence", "AnatomicRegionSequence"}) {
        if (const std::string value = code(key); !value.empty()) name.codes.push_back(value);
      }
      for (const char* key :
           {"SegmentedPropertyTypeModifierCodeSequence", "AnatomicRegionModifierSequence"}) {
        const std::string side = volume::SideOfCode(code(key));
        if (!side.empty()) name.side = side;
      }
    }
  }
  return names;
}

volume::ValueNames NamesOfDocument(const json& document, const fs::path& file) {
  static const json::json_pointer kChannels("/network_data_format/outputs/pred/channel_def");
  if (!document.is_object()) return {};
  if (document.contains(kChannels)) return NamesIn(document.at(kChannels), file);
  if (document.contains("segmentAttributes") && document.at("segmentAttributes").is_array()) {
    return NamesOfSegments(document.at("segmentAttributes"), file);
  }
  return NamesIn(document.contains("labels") ? document.at("labels") : document, file);
}

/// The table of BIDS: columns index and name. Empty if the file is another table.
volume::ValueNames NamesOfTable(const fs::path& file) {
  const CsvTable table(file);
  volume::ValueNames names;
  if (!table.Has("index") || !table.Has("name")) return names;
  const std::vector<double> values = table.Numbers("index");
  const std::vector<std::string> texts = table.Texts("name");
  for (std::size_t row = 0; row < values.size(); ++row) {
    ACUS_REQUIRE(values[row] == std::round(values[row]) && std::abs(values[row]) < 2e9,
                 table.Where(row), ": index is ", values[row], "; a whole number is needed");
    AddName(static_cast<std::int32_t>(values[row]), texts[row], file, names);
  }
  return names;
}

/// Names in the table of a map, or of all maps in its folder (BIDS: "..._dseg.nii.gz").
NamesBeside FindNamesInTable(const fs::path& label_map) {
  const std::string stem = volume::VolumeStem(label_map);
  std::vector<fs::path> candidates = {label_map.parent_path() / (stem + ".tsv")};
  if (stem.ends_with("dseg")) candidates.push_back(label_map.parent_path() / "dseg.tsv");
  for (const fs::path& candidate : candidates) {
    std::error_code error;
    if (!fs::is_regular_file(candidate, error)) continue;
    volume::ValueNames names = NamesOfTable(candidate);
    if (!names.empty()) return {std::move(names), candidate.lexically_normal()};
  }
  return {};
}

}  // namespace

NamesBeside FindNamesBeside(const fs::path& label_map) {
  if (NamesBeside found = FindNamesInTable(label_map); !found.names.empty()) return found;
  const fs::path folder = label_map.parent_path();
  std::vector<fs::path> candidates = {folder / (volume::VolumeStem(label_map) + ".json")};
  for (const fs::path& place : {folder, folder / ".."}) {
    for (const char* name : {"dataset.json", "metadata.json"}) candidates.push_back(place / name);
  }
  for (const fs::path& candidate : candidates) {
    std::error_code error;
    if (!fs::is_regular_file(candidate, error)) continue;
    volume::ValueNames names;
    try {
      names = NamesOfDocument(config::ReadJson(candidate), candidate);
    } catch (const json::exception& wrong) {
      throw InputError(
          Message(candidate.string(), ": names the values of ", label_map.filename().string(),
                  " in a form that is not read; {\"labels\": {\"1\": \"spleen\"}} is"));
    }
    if (!names.empty()) return {std::move(names), candidate.lexically_normal()};
  }
  return {};
}

}  // namespace acus::segmentation
