#include "acus/patient/segmentation/import/imported_labels.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <set>
#include <utility>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/words.h"
#include "acus/data/volume/dicom_frame.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/names_beside.h"
#include "acus/data/volume/scalar_file.h"
#include "acus/patient/segmentation/import/foreign_map.h"

namespace acus::segmentation {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostListed = 12;

std::set<std::int32_t> ValuesThatOccur(const volume::Grid<std::int32_t>& values) {
  std::set<std::int32_t> occurring;
  std::int32_t last = 0;
  for (const std::int32_t value : values.voxels) {
    if (value != last && value != 0) occurring.insert(value);
    last = value;
  }
  return occurring;
}

/// What --mapping names.
enum class Table {
  kNone,
  kStructures,  ///< acus-label-names: what names mean.
  kValues,      ///< acus-label-mapping: what values mean.
  kNames        ///< Names of the values, of another program.
};

Table KindOf(const fs::path& mapping) {
  if (mapping.empty()) return Table::kNone;
  const std::string text = ReadTextFile(mapping);
  const bool is_json = mapping.extension() == ".json" || Trimmed(text).starts_with('{');
  if (!is_json) return Table::kNames;
  const nlohmann::json document = config::ReadJson(mapping);
  const bool is_ours = document.is_object() && document.contains("format");
  if (!is_ours) return Table::kNames;
  const nlohmann::json& format = document.at("format");
  const bool has_names =
      format.is_string() && format.get<std::string>().starts_with("acus-label-names/");
  return has_names ? Table::kStructures : Table::kValues;
}

volume::ValueNames NamesInMapping(const fs::path& mapping) {
  volume::ValueNames names = volume::NamesInFile(mapping);
  ACUS_REQUIRE(!names.empty(), mapping.string(),
               ": names no values of a label map. Read are label descriptions of ITK-SNAP, colour "
               "tables of 3D Slicer and FreeSurfer, tables with the columns index and name, JSON "
               "files with labels, and the formats acus-label-mapping/1 and acus-label-names/1");
  return names;
}

/// The values of a map and what is said of them; the frame of reference is that of the CT.
volume::NamedValues ReadMap(const ForeignLabels& labels, Table table, const volume::Geometry& grid,
                            const RunContext& context) {
  const fs::path object = DicomLabelsIn(labels.file);
  volume::DicomFrame ct;
  if (!object.empty() && !labels.ct.empty()) {
    ct = volume::FrameOfCt(labels.ct, labels.series, context.num_threads);
    volume::RequireSameFrame(volume::FrameOfLabels(object), ct, labels.accept_other_frame, object,
                             context);
  }
  volume::NamedValues map = ReadForeignMap(labels.file, grid, ct.uids);
  if (table == Table::kNames) {
    map.names = NamesInMapping(labels.mapping);
    map.named_by = "by " + labels.mapping.filename().string();
    map.is_named_beside = false;
  }
  return map;
}

/// What to do about names that the table does not have.
std::string AdviceFor(const std::vector<std::pair<std::int32_t, std::string>>& unknown,
                      const LabelNames& table) {
  std::string text;
  for (std::size_t n = 0; n < unknown.size() && n < kMostListed; ++n) {
    const auto& [value, name] = unknown[n];
    const auto nearest = table.Nearest(name);
    text += Message(n == 0 ? " " : ", ", "'", name, "' (", value, ")",
                    nearest ? Message(", like '", *nearest, "'?") : std::string());
  }
  if (unknown.size() > kMostListed) text += Message(" and ", unknown.size() - kMostListed, " more");
  return text;
}

/// The mapping that names give.
LabelMapping MappingByNames(const volume::NamedValues& map, const LabelNames& table,
                            const fs::path& path) {
  LabelMapping mapping;
  std::vector<std::pair<std::int32_t, std::string>> unknown;
  for (const std::int32_t value : ValuesThatOccur(map.values)) {
    const auto name = map.names.find(value);
    const auto found = name == map.names.end() ? std::nullopt : table.Find(name->second);
    if (found) {
      mapping.tissue[value] = found->structure.tissue;
      mapping.name[value] = name->second.text.empty() ? found->structure.name : name->second.text;
    } else {
      unknown.emplace_back(value, name == map.names.end() ? "no name" : name->second.text);
    }
  }
  ACUS_REQUIRE(unknown.empty(), path.string(), ": values named ", map.named_by,
               " are no structures of the table:", AdviceFor(unknown, table),
               "; add them to a copy of label_maps/names.json (tissue 'outside' for what should be "
               "ignored) and give it by --mapping");
  mapping.covers_body = table.CoversBody(map.names);
  mapping.all_bones = table.HasAllBones(map.names);
  return mapping;
}

/// Words as they are written; capitals may begin others ("LeftKidney").
std::vector<std::string> WordsOfName(const fs::path& file) {
  std::vector<std::string> words(1);
  bool was_lower = false;
  for (const char c : volume::VolumeStem(file)) {
    const auto letter = static_cast<unsigned char>(c);
    const bool begins = std::isalnum(letter) == 0 || (was_lower && std::isupper(letter) != 0);
    if (begins && !words.back().empty()) words.emplace_back();
    if (std::isalnum(letter) != 0) words.back() += c;
    was_lower = std::islower(letter) != 0;
  }
  return words;
}

/// Whether words name something else than a structure.
bool NameAnother(std::span<const std::string> words, const std::string& structure,
                 const LabelNames& table) {
  for (std::size_t begin = 0; begin < words.size(); ++begin) {
    for (std::size_t count = 1; begin + count <= words.size(); ++count) {
      const auto known =
          table.Find({.text = Joined(words.subspan(begin, count), "_"), .codes = {}});
      if (known && known->structure.name != structure) return true;
    }
  }
  return false;
}

/// The structure that a file's name states: that of the most words of it that are one after the
/// other in the table. Nothing if there is none, or the other words name a second one
/// ("kidney_left_tumor").
std::optional<volume::ValueName> StructureInName(const fs::path& file, const LabelNames& table) {
  const std::vector<std::string> words = WordsOfName(file);
  for (std::size_t count = words.size(); count > 0; --count) {
    for (std::size_t begin = 0; begin + count <= words.size(); ++begin) {
      const std::span<const std::string> all = words;
      const volume::ValueName name{.text = Joined(all.subspan(begin, count), "_"), .codes = {}};
      const auto known = table.Find(name);
      if (!known) continue;
      const std::string& structure = known->structure.name;
      const bool is_only = !NameAnother(all.first(begin), structure, table) &&
                           !NameAnother(all.subspan(begin + count), structure, table);
      return is_only ? std::optional(name) : std::nullopt;
    }
  }
  return {};
}

/// The name of the one value of a file that names none: the file's. A value beyond those of masks
/// must mean the same in the default table.
/// @throws InputError if there is no such name, or another: a guess could be any organ.
volume::ValueNames NamesOfOneValue(std::int32_t value, const LabelNames& table,
                                   const LabelMapping& defaults, const fs::path& file) {
  const auto name = StructureInName(file, table);
  const auto by_default = defaults.name.find(value);
  const std::string other = by_default == defaults.name.end() ? "" : by_default->second;
  const bool is_mask = value == 1 || value == 255;
  const auto known = name ? table.Find(*name) : std::nullopt;
  const auto default_known =
      other.empty() ? std::nullopt : table.Find({.text = other, .codes = {}});
  const bool agree =
      is_mask || (known && default_known && known->structure.name == default_known->structure.name);
  ACUS_REQUIRE(
      known && agree, file.string(), ": has one value, ", value, ", and no name for it",
      known && !agree ? Message(": by the file's name it is '", name->text, "'") : std::string(),
      !is_mask && !other.empty()
          ? Message(known ? ", " : ": ", "in TotalSegmentator's table it is '", other, "'")
          : std::string(),
      ". Which structure is it? Name a mask of 0 and 1 after it (liver.nii.gz), or give a "
      "table of values (acus-label-mapping/1) by --mapping");
  return {{value, *name}};
}

/// A table beside a mask may be that of another map.
/// @throws InputError if it names the mask's one value as another structure than the file's name.
void RequireNameOfFile(const volume::NamedValues& map, const LabelNames& table,
                       const fs::path& file) {
  const auto values = ValuesThatOccur(map.values);
  if (!map.is_named_beside || values.size() != 1) return;
  const auto beside = map.names.find(*values.begin());
  const auto by_file = StructureInName(file, table);
  if (beside == map.names.end() || !by_file) return;
  const auto known = table.Find(beside->second);
  const auto stated = table.Find(*by_file);
  ACUS_REQUIRE(!known || known->structure.name == stated->structure.name, file.string(),
               ": has one value, ", *values.begin(), ": ", map.named_by, " it is '",
               known->structure.name, "', by the file's name '", stated->structure.name,
               "'. Which structure is it? Give a table of its names by --mapping, or move the "
               "mask to a folder of its own");
}

/// What a value of a table is; a tissue by its own name if the table's words are not known.
std::optional<NamedStructure> StructureOf(std::int32_t value, const LabelMapping& mapping,
                                          const LabelNames& names) {
  const volume::Label tissue = mapping.tissue.at(value);
  const auto named = names.Find({.text = mapping.name.at(value), .codes = {}});
  if (named && named->structure.tissue == tissue) return named;
  const std::string name(volume::StandardLabels()[tissue].name);
  return tissue == 0 ? std::nullopt : names.Find({.text = name, .codes = {}});
}

std::map<std::int32_t, NamedStructure> StructuresOf(const ImportedLabels& import) {
  std::map<std::int32_t, NamedStructure> structures;
  for (const std::int32_t value : ValuesThatOccur(import.values)) {
    if (!import.mapping.tissue.contains(value)) continue;
    const auto own = import.own_names.find(value);
    auto found = own == import.own_names.end() ? std::nullopt : import.names.Find(own->second);
    if (!found || found->structure.tissue != import.mapping.tissue.at(value)) {
      found = StructureOf(value, import.mapping, import.names);
    }
    if (found) structures.emplace(value, *found);
  }
  return structures;
}

}  // namespace

ImportedLabels ReadImportedLabels(const ForeignLabels& labels, const volume::Geometry& grid,
                                  const RunContext& context) {
  const Table table_kind = KindOf(labels.mapping);
  const bool by_names = table_kind != Table::kValues;
  const bool own_table = table_kind == Table::kStructures;
  volume::NamedValues map = ReadMap(labels, table_kind, grid, context);
  ImportedLabels import{
      .file = labels.file,
      .values = {},
      .mapping = {},
      .named_by = map.named_by,
      .own_names = {},
      .names =
          LabelNames(own_table ? labels.mapping : config::FindConfig("label_maps/names.json", ".")),
      .structures = {}};
  ACUS_REQUIRE(
      std::ranges::any_of(map.values.voxels, [](std::int32_t value) { return value != 0; }),
      labels.file.string(), ": has no labelled voxel, so that there is nothing to import");
  const bool is_ours = labels.file.string().ends_with(".seg.nrrd");
  if (by_names && map.names.empty() && !is_ours) {
    const auto values = ValuesThatOccur(map.values);
    if (values.size() == 1) {
      const LabelMapping defaults =
          ReadLabelMapping(config::FindConfig("label_maps/totalsegmentator.json", "."));
      map.names = NamesOfOneValue(*values.begin(), import.names, defaults, labels.file);
      map.named_by = "by the file's name";
      import.named_by = map.named_by;
    }
  }
  RequireNameOfFile(map, import.names, labels.file);
  ACUS_REQUIRE(!own_table || !map.names.empty(), labels.file.string(),
               ": neither the file nor one beside it names its values, so ",
               labels.mapping.filename().string(),
               " cannot be used; give a table of values (format acus-label-mapping/1)");
  if (by_names && !map.names.empty()) {
    import.mapping = MappingByNames(map, import.names, labels.file);
  } else {
    const fs::path table =
        !labels.mapping.empty()
            ? labels.mapping
            : config::FindConfig(
                  is_ours ? "label_maps/acus.json" : "label_maps/totalsegmentator.json", ".");
    import.mapping = ReadLabelMapping(table);
    import.named_by = "by the values of " + table.filename().string();
    if (labels.mapping.empty()) {
      context.Warn(Message(labels.file.string(),
                           ": neither the file nor one beside it names its values; those of ",
                           table.filename().string(), " are assumed. Another table: --mapping"));
    }
  }
  import.values = ValuesOnGrid(map.values, grid, labels.file, context);
  import.own_names = std::move(map.names);
  // Refuses values that the table does not have, before anything is made of the others.
  for (const std::int32_t value : ValuesThatOccur(import.values)) {
    if (!import.mapping.tissue.contains(value)) TissuesIn(import);
  }
  import.structures = StructuresOf(import);
  return import;
}

volume::LabelMap TissuesIn(const ImportedLabels& import) {
  return Translated(import.values, import.mapping, import.file);
}

std::string ImportSentence(const ImportedLabels& import) {
  return Message(import.file.string(), ": ", ValuesThatOccur(import.values).size(), " structures, ",
                 import.named_by, "\n");
}

}  // namespace acus::segmentation
