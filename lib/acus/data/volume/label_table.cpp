#include "acus/data/volume/label_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/base/core/number_text.h"
#include "acus/base/core/words.h"
#include "acus/data/volume/terminology.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMostTableBytes = 16U << 20U;
constexpr std::ptrdiff_t kColourParts = 3;  ///< At least: red, green, blue.

using LabelRow = std::pair<std::int32_t, std::string>;

std::vector<std::string> CellsOf(std::string_view text) {
  std::vector<std::string> cells(1);
  for (const char c : text) {
    const bool divides = std::string_view(" \t,;:=").find(c) != std::string_view::npos;
    if (!divides) cells.back() += c;
    if (divides && !cells.back().empty()) cells.emplace_back();
  }
  if (cells.back().empty()) cells.pop_back();
  return cells;
}

bool IsNumber(const std::string& cell) {
  return ParseFinite(cell).has_value();
}

/// The name in cells that follow the value: before a colour, "whatever" after which is no name.
std::string NameIn(const std::vector<std::string>& cells) {
  const bool is_plain = cells.size() > kColourParts && !IsNumber(cells[0]) &&
                        std::all_of(cells.begin() + 1, cells.begin() + 1 + kColourParts, IsNumber);
  if (is_plain) return cells[0];
  const auto colour = std::find_if_not(cells.rbegin(), cells.rend(), IsNumber).base();
  if (colour == cells.begin()) return {};
  const auto parts = cells.end() - colour;
  // "rib left 1 10 20 30 255": a colour has four parts, or three.
  const auto end = parts > kColourParts    ? cells.end() - kColourParts - 1
                   : parts == kColourParts ? colour
                                           : cells.end();
  return Joined(std::vector<std::string>(cells.begin(), end), " ");
}

/// A row that begins with a value and has a name.
std::optional<LabelRow> RowIn(std::string_view line) {
  const std::size_t end = std::min(line.find_first_of(" \t,;:="), line.size());
  const auto value = ParseNumber<std::int32_t>(line.substr(0, end));
  if (!value) return {};
  const std::string_view rest = line.substr(end);
  const std::size_t open = rest.find('"');
  const std::size_t close = rest.rfind('"');
  if (open == close) {
    const std::string name = NameIn(CellsOf(rest));
    return name.empty() ? std::nullopt : std::optional(LabelRow(*value, name));
  }
  const bool has_numbers = std::ranges::all_of(CellsOf(rest.substr(0, open)), IsNumber) &&
                           std::ranges::all_of(CellsOf(rest.substr(close + 1)), IsNumber);
  const std::string name(Trimmed(rest.substr(open + 1, close - open - 1)));
  return has_numbers ? std::optional(LabelRow(*value, name)) : std::nullopt;
}

/// Whether the name of a file, or a comment in it, says that it names labels.
bool SaysLabels(const fs::path& file, const std::vector<std::string>& lines) {
  const std::string ending = file.extension().string();
  const bool by_ending = ending == ".ctbl" || ending == ".lut" || ending == ".label";
  return by_ending || std::ranges::any_of(lines, [](const std::string& line) {
           return line.starts_with('#') && (line.find("Label Description File") != line.npos ||
                                            line.find("Color table file") != line.npos);
         });
}

ValueNames NamesInRows(const fs::path& file, const std::vector<std::string>& lines) {
  const bool must_fit = SaysLabels(file, lines);
  ValueNames names;
  for (std::size_t n = 0; n < lines.size(); ++n) {
    const std::string_view line = Trimmed(lines[n]);
    if (line.empty() || IsCommentLine(line)) continue;
    const auto row = RowIn(line);
    ACUS_REQUIRE(row || !must_fit, file.string(), ":", n + 1, ": '", line.substr(0, 60),
                 "' names no value of a label map; rows are such as '1 255 0 0 1 1 1 \"liver\"' "
                 "(ITK-SNAP) or '1 liver 255 0 0 255' (3D Slicer, FreeSurfer)");
    if (!row) return {};
    AddValueName(row->first, {.text = row->second, .codes = {}}, file.string(), names);
  }
  return names;
}

constexpr std::array<std::string_view, 7> kIndexColumns = {
    "index", "LabelValue", "label_value", "value", "label_id", "id", "label"};
constexpr std::array<std::string_view, 5> kNameColumns = {"name", "label_name", "structure",
                                                          "region", "label"};

std::optional<std::string_view> FirstColumn(const CsvTable& table,
                                            std::span<const std::string_view> names) {
  const auto found = std::ranges::find_if(names, [&](auto name) { return table.Has(name); });
  return found == names.end() ? std::nullopt : std::optional(*found);
}

/// Whether a row may be the header of such a table: another table is none of ours to refuse.
bool MayBeHeader(std::string_view line) {
  std::set<std::string> words;
  for (const std::string& cell : CellsOf(line)) {
    const std::size_t from = cell.find_first_not_of('"');
    const std::size_t to = cell.find_last_not_of('"');
    if (from != cell.npos) words.insert(ParseColumnName(cell.substr(from, to - from + 1)).words);
  }
  const auto has = [&](std::string_view name) {
    return words.contains(ParseColumnName(name).words);
  };
  return std::ranges::any_of(kIndexColumns, has) && std::ranges::any_of(kNameColumns, has) &&
         words.size() > 1;
}

/// The SNOMED CT codes of one kind in a table of 3D Slicer, by row; empty where there are none.
std::vector<std::string> CodesOf(const CsvTable& table, const std::string& kind) {
  const std::string scheme = kind + "_CodingScheme", code = kind + "_CodeValue";
  std::vector<std::string> codes(table.num_rows());
  if (!table.Has(scheme) || !table.Has(code)) return codes;
  const auto schemes = table.Texts(scheme);
  codes = table.Texts(code);
  for (std::size_t row = 0; row < codes.size(); ++row) {
    if (schemes[row] != "SCT") codes[row].clear();
  }
  return codes;
}

ValueNames NamesInColumns(const fs::path& file) {
  const CsvTable table(file);
  const auto index = FirstColumn(table, kIndexColumns);
  const auto name = FirstColumn(table, kNameColumns);
  if (!index || !name || index == name) return {};
  const std::vector<double> values = table.Numbers(*index);
  const std::vector<std::string> texts = table.Texts(*name);
  const auto types = CodesOf(table, "Type"), regions = CodesOf(table, "Region");
  const auto sides = CodesOf(table, "TypeModifier"),
             region_sides = CodesOf(table, "RegionModifier");
  ValueNames names;
  for (std::size_t row = 0; row < values.size(); ++row) {
    ACUS_REQUIRE(values[row] == std::round(values[row]) && std::abs(values[row]) < 2e9,
                 table.Where(row), ": ", *index, " is ", values[row], "; a whole number is needed");
    ValueName entry{.text = texts[row], .codes = {}};
    for (const auto* codes : {&types, &regions}) {
      if (!(*codes)[row].empty()) entry.codes.push_back((*codes)[row]);
    }
    for (const auto* codes : {&sides, &region_sides}) {
      if (const auto side = SideOfCode((*codes)[row]); !side.empty()) entry.side = side;
    }
    AddValueName(static_cast<std::int32_t>(values[row]), std::move(entry), file.string(), names);
  }
  return names;
}

}  // namespace

void AddValueName(std::int32_t value, ValueName name, const std::string& file, ValueNames& names) {
  if (value == 0) return;  // The background.
  const std::string text = name.text;
  const auto [place, is_new] = names.try_emplace(value, std::move(name));
  ACUS_REQUIRE(is_new, file, ": value ", value, " is '", place->second.text, "' and '", text,
               "'; a value needs one name");
}

ValueNames NamesInTable(const fs::path& file) {
  if (RequireInputFile(file) > kMostTableBytes) return {};  // No table of names.
  const auto lines = LinesOf(Utf8Text(ReadTextFile(file), file.string()));
  const auto first = std::ranges::find_if(lines, [](const std::string& line) {
    return !Trimmed(line).empty() && !IsCommentLine(Trimmed(line));
  });
  if (first == lines.end()) return {};
  const bool may_have_header = file.extension() == ".csv" || file.extension() == ".tsv";
  if (may_have_header && !RowIn(Trimmed(*first))) {
    return MayBeHeader(*first) ? NamesInColumns(file) : ValueNames();
  }
  return NamesInRows(file, lines);
}

}  // namespace acus::volume
