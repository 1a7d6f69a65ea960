#include "acus/base/core/csv.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"
#include "acus/base/core/spelling.h"
#include "acus/base/core/table_sidecar.h"
#include "acus/base/core/words.h"

namespace acus {
namespace {

constexpr std::size_t kLinesForHeader = 60;

/// The most frequent number of cells; of equally frequent ones the largest.
std::size_t UsualCount(const std::vector<std::vector<std::string>>& rows) {
  std::map<std::size_t, std::size_t> times;
  for (const auto& row : rows) ++times[row.size()];
  std::size_t usual = 0;
  for (const auto& [count, rows_of_it] : times) {
    if (usual == 0 || rows_of_it >= times[usual]) usual = count;
  }
  return usual;
}

/// Where most rows of data follow each other: a preamble may have numbers here and there.
std::size_t FirstOfLongestRun(const std::vector<bool>& has_data) {
  std::size_t first = has_data.size();
  std::size_t longest = 0;
  std::size_t run = 0;
  for (std::size_t i = 0; i < has_data.size(); ++i) {
    run = has_data[i] ? run + 1 : 0;
    if (run <= longest) continue;
    longest = run;
    first = i + 1 - run;
  }
  return first;
}

bool IsFull(std::span<const std::string> cells) {
  return std::ranges::none_of(cells, &std::string::empty);
}

bool IsUnitRow(std::span<const std::string> cells) {
  const auto is_unit = [](const std::string& cell) { return cell.empty() || IsUnitCell(cell); };
  return std::ranges::all_of(cells, is_unit) && !std::ranges::all_of(cells, &std::string::empty);
}

/// The names in a comment right before the rows ("# time_s depth_mm force_n"), as a row of the
/// style; empty unless there are as many as cells in the first row, which holds numbers.
std::string HeaderInComment(std::string_view comment, std::string_view first_row,
                            const TableStyle& style) {
  const auto is_number = [&](const std::string& cell) {
    return NumberInCell(cell, style.has_decimal_comma).has_value();
  };
  std::vector<std::string> cells, names;
  SplitCells(first_row, style.separator, cells);
  if (std::ranges::none_of(cells, is_number)) return {};
  comment = Trimmed(comment);
  comment.remove_prefix(std::min(comment.find_first_not_of("#%/ \t"), comment.size()));
  for (const char separator : {style.separator, ',', ';', '\t', ' '}) {
    SplitCells(comment, separator, names);
    const bool fits =
        names.size() == cells.size() && IsFull(names) && std::ranges::none_of(names, is_number);
    if (!fits) continue;
    std::string row;
    for (const std::string& name : names) {
      row += (row.empty() ? "\"" : std::string(1, style.separator) + '"') + name + '"';
    }
    return row;
  }
  return {};
}

}  // namespace

CsvTable::CsvTable(const std::filesystem::path& path) : path_(path) {
  const TableSidecar sidecar = SidecarOf(path);
  std::string text = ReadTextFile(path);
  columns_ = sidecar.columns;
  const bool has_header = columns_.empty();
  if (!has_header && sidecar.rate_hz) {
    columns_.insert(columns_.begin(), "time_s");
    text = WithTimes(Utf8Text(std::move(text), path.string()), *sidecar.rate_hz, sidecar.start_s);
  }
  Parse(std::move(text), has_header);
  if (sidecar.path.empty()) return;
  std::vector<std::string> units;
  for (const std::string& column : columns_) {
    const auto found = sidecar.units.find(column);
    units.push_back(found == sidecar.units.end() ? "" : found->second);
  }
  TakeUnits(units);
  how_read_ += Message(how_read_.empty() ? "" : "; ", has_header ? "units" : "columns", " as in ",
                       sidecar.path.filename().string());
}

CsvTable::CsvTable(const std::filesystem::path& path,
                   std::initializer_list<std::string_view> columns)
    : path_(path), columns_(columns.begin(), columns.end()) {
  Parse(ReadTextFile(path), /*has_header=*/false);
}

void CsvTable::Split(std::string_view line, std::vector<std::string>& cells) const {
  if (!style_.IsPlain() || line.find('"') != line.npos) {
    SplitCells(line, style_.separator, cells);
    return;
  }
  std::size_t count = 0;
  for (std::size_t begin = 0; begin <= line.size(); ++count) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    if (count == cells.size()) cells.emplace_back();
    cells[count] = Trimmed(line.substr(begin, end - begin));
    begin = end + 1;
  }
  cells.resize(count);
}

bool CsvTable::HasNumber(std::span<const std::string> cells) const {
  return std::ranges::any_of(cells, [this](const std::string& cell) {
    return NumberInCell(cell, style_.has_decimal_comma).has_value();
  });
}

/// Appends the units of a row of them to the names that have none.
void CsvTable::TakeUnits(std::span<const std::string> units) {
  for (std::size_t i = 0; i < columns_.size() && i < units.size(); ++i) {
    const bool is_open = !units[i].empty() && ParseColumnName(columns_[i]).unit.empty();
    if (!is_open) continue;
    const bool in_brackets = std::string_view("([{").find(units[i][0]) != std::string_view::npos;
    columns_[i] += in_brackets ? " " + units[i] : " (" + units[i] + ")";
  }
}

/// Finds the header in the first lines. @returns the index of the first line after it.
std::size_t CsvTable::TakeHeader(std::span<const Line> lines) {
  std::vector<std::vector<std::string>> rows(std::min(lines.size(), kLinesForHeader));
  for (std::size_t i = 0; i < rows.size(); ++i) Split(lines[i].text, rows[i]);
  const std::size_t usual = UsualCount(rows);
  std::size_t header = 0;
  std::size_t next = 1;
  const bool begins_at_once = rows[0].size() == usual && IsFull(rows[0]) && !HasNumber(rows[0]);
  if (!begins_at_once) {
    std::vector<bool> has_data;
    for (const auto& row : rows) has_data.push_back(row.size() == usual && HasNumber(row));
    const std::size_t data = FirstOfLongestRun(has_data);
    if (data > 0 && data < rows.size()) {
      header = data - 1;
      if (header > 0 && IsUnitRow(rows[header])) --header;
      next = header + 1;
    }
  }
  columns_ = rows[header];
  while (!columns_.empty() && columns_.back().empty()) columns_.pop_back();
  if (next < rows.size() && IsUnitRow(rows[next]) && !HasNumber(rows[next])) {
    TakeUnits(rows[next]);
    how_read_ += "; a row of units";
    ++next;
  }
  if (header > 0) {
    how_read_ += Message("; header in line ", lines[header].number, ", ", header,
                         header == 1 ? " row" : " rows", " before it skipped");
  }
  ACUS_REQUIRE(
      header > 0 || next > 1 ||
          !std::ranges::all_of(columns_,
                               [this](const std::string& name) {
                                 return NumberInCell(name, style_.has_decimal_comma).has_value();
                               }),
      path_.string(), ":", lines[0].number,
      ": begins with numbers; a row with the names of the columns is needed before them");
  auto sorted = columns_;
  std::ranges::sort(sorted);
  const auto twice = std::ranges::adjacent_find(sorted);
  ACUS_REQUIRE(twice == sorted.end(), path_.string(), ":", lines[header].number, ": column '",
               *twice, "' appears twice");
  return next;
}

void CsvTable::AddRow(const Line& line, bool is_last_and_open) {
  Split(line.text, row_);
  while (row_.size() > columns_.size() && row_.back().empty()) row_.pop_back();
  if (row_.size() != columns_.size()) {
    const bool may_be_decimals = style_.IsPlain() && row_.size() > columns_.size();
    throw InputError(Message(
        path_.string(), ":", line.number, ": has ", row_.size(), " cells, the columns are ",
        columns_.size(), " (", Joined(columns_, ","), ")",
        is_last_and_open  ? "; the last line has no end: is the file cut off?"
        : may_be_decimals ? "; a comma may separate cells or decimals here: write decimals with a "
                            "point, or separate cells by ';'"
                          : "; complete the row, or remove it"));
  }
  cells_.insert(cells_.end(), row_.begin(), row_.end());
  line_.push_back(line.number);
}

void CsvTable::Parse(std::string bytes, bool has_header) {
  const std::string name = path_.string();
  ACUS_REQUIRE(!bytes.starts_with("PK\x03\x04"), name,
               ": is a ZIP archive or a workbook (.xlsx, .ods), not a CSV file; save the sheet as "
               "CSV, or unpack the archive");
  const std::string text = Utf8Text(std::move(bytes), name);
  style_ = StyleOf(text, name);
  std::vector<Line> lines;
  std::string_view comment;  // The last one before the rows.
  std::size_t number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view line = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    ++number;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (IsCommentLine(line) && lines.empty()) comment = line;
    if (Trimmed(line).empty() || IsCommentLine(line)) continue;
    ACUS_REQUIRE(line.find('\0') == line.npos, name, ":", number,
                 ": has a zero byte; this is not a CSV file");
    lines.push_back({line, number});
  }
  ACUS_REQUIRE(!has_header || !lines.empty(), name, ": is empty; a header row is needed");
  std::string commented;
  if (has_header && !comment.empty()) commented = HeaderInComment(comment, lines[0].text, style_);
  if (!commented.empty()) {
    lines.insert(lines.begin(), {commented, lines[0].number - 1});
    how_read_ += "; names of the columns in a comment";
  }
  std::size_t next = 0;
  if (has_header) {
    next = TakeHeader(lines);
  } else if (!lines.empty()) {
    Split(lines[0].text, row_);
    if (!HasNumber(row_)) next = 1;
  }
  std::size_t num_empty = 0;
  for (std::size_t i = next; i < lines.size(); ++i) {
    if (lines[i].text.find_first_not_of(" \t,;|\"") == std::string_view::npos) {
      ++num_empty;
      continue;
    }
    AddRow(lines[i], i + 1 == lines.size() && !text.ends_with('\n'));
  }
  if (num_empty > 0) how_read_ += Message("; ", num_empty, " empty rows skipped");
  if (!style_.IsPlain()) how_read_ = "; " + style_.Text() + how_read_;
  if (!how_read_.empty()) how_read_.erase(0, 2);
}

/// The column of this name, or those of the same words in a unit of the same kind.
std::vector<CsvTable::Place> CsvTable::PlacesOf(std::string_view column) const {
  if (const auto given = given_.find(column); given != given_.end()) return {given->second};
  const auto found = std::ranges::find(columns_, column);
  if (found != columns_.end()) {
    return {{.index = static_cast<std::size_t>(found - columns_.begin()), .factor = 1.0}};
  }
  const ColumnName wanted = ParseColumnName(column);
  std::vector<Place> places;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const ColumnName name = ParseColumnName(columns_[i]);
    if (name.words != wanted.words) continue;
    if (name.unit == wanted.unit) {
      places.push_back({.index = i, .factor = 1.0});
    } else if (const auto factor = UnitFactor(name.unit, wanted.unit)) {
      places.push_back({.index = i, .factor = *factor});
    }
  }
  return places;
}

CsvTable::Place CsvTable::PlaceOf(std::string_view column) const {
  const auto places = PlacesOf(column);
  ACUS_REQUIRE(places.size() <= 1, path_.string(), ": '", column, "' may be column '",
               columns_[places.front().index], "' or '", columns_[places.back().index],
               "'; rename the one that is not meant");
  if (!places.empty()) return places.front();
  const ColumnName wanted = ParseColumnName(column);
  for (std::size_t i = 0; i < columns_.size() && !wanted.unit.empty(); ++i) {
    const ColumnName here = ParseColumnName(columns_[i]);
    if (here.words == wanted.words && here.unit.empty()) InUnitOf(column, i, "");
  }
  const auto nearest = NearestSpelling(column, columns_);
  throw InputError(Message(path_.string(), ":1: no column '", column, "'; the header is ",
                           Joined(columns_, ","),
                           nearest ? Message("; rename '", *nearest, "'?") : std::string()));
}

CsvTable::Place CsvTable::InUnitOf(std::string_view column, std::size_t index,
                                   std::string_view unit) const {
  const std::string wanted = ParseColumnName(column).unit;
  const std::string here = unit.empty() ? ParseColumnName(columns_[index]).unit : std::string(unit);
  ACUS_REQUIRE(!here.empty(), path_.string(), ": column '", columns_[index],
               "' does not say its unit; name it '", column, "', or with its own unit in brackets");
  const auto factor = here == wanted ? 1.0 : UnitFactor(here, wanted);
  ACUS_REQUIRE(factor, path_.string(), ": column '", columns_[index], "' is in '", here,
               "', which cannot be converted to ", wanted);
  return {.index = index, .factor = *factor};
}

void CsvTable::Accept(std::string_view column, std::span<const std::string_view> words) {
  if (!PlacesOf(column).empty()) return;
  const std::string own = ParseColumnName(column).words;
  std::vector<std::size_t> fitting;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const ColumnName name = ParseColumnName(columns_[i]);
    if (name.words == own || std::ranges::find(words, name.words) != words.end()) {
      fitting.push_back(i);
    }
  }
  if (fitting.empty()) return;  // The message of a missing column lists the columns.
  ACUS_REQUIRE(fitting.size() == 1, path_.string(), ": '", column, "' may be column '",
               columns_[fitting[0]], "' or '", columns_[fitting[1]],
               "'; name the one that is "
               "meant ",
               column, ", or give a mapping (--columns)");
  given_.emplace(column, InUnitOf(column, fitting[0], ""));
}

void CsvTable::Take(std::string_view column, std::string_view name_or_number,
                    std::string_view unit) {
  std::size_t index = columns_.size();
  const auto number = ParseNumber<std::size_t>(name_or_number);
  for (std::size_t i = 0; i < columns_.size() && index == columns_.size(); ++i) {
    const bool is_named =
        columns_[i] == name_or_number ||
        ParseColumnName(columns_[i]).words == ParseColumnName(name_or_number).words;
    if (is_named || (number && *number == i + 1)) index = i;
  }
  ACUS_REQUIRE(index < columns_.size(), path_.string(), ": has no column '", name_or_number,
               "'; change the mapping (--columns); there are: ", Joined(columns_));
  given_.insert_or_assign(std::string(column), InUnitOf(column, index, unit));
}

bool CsvTable::Has(std::string_view column) const {
  return !PlacesOf(column).empty();
}

std::string CsvTable::Taken(std::string_view column) const {
  const std::string& name = columns_[PlaceOf(column).index];
  return name == column ? std::string() : Message(column, " from '", name, "'");
}

std::vector<double> CsvTable::Numbers(std::string_view column) const {
  const Place place = PlaceOf(column);
  std::vector<double> values(num_rows());
  for (std::size_t row = 0; row < values.size(); ++row) {
    const std::string& cell = cells_[row * columns_.size() + place.index];
    const auto value = NumberInCell(cell, style_.has_decimal_comma);
    ACUS_REQUIRE(value, Where(row), ": ", column, " is '", cell, "'; a finite number is needed");
    values[row] = *value * place.factor;
  }
  return values;
}

std::size_t CsvTable::DropRowsWithout(std::span<const std::string_view> columns) {
  std::vector<std::size_t> needed;
  for (const std::string_view column : columns) needed.push_back(PlaceOf(column).index);
  const std::size_t width = columns_.size();
  std::size_t kept = 0;
  for (std::size_t row = 0; row < num_rows(); ++row) {
    const auto is_missing = [&](std::size_t i) { return IsMissingCell(cells_[row * width + i]); };
    if (std::ranges::any_of(needed, is_missing)) continue;
    if (kept != row) {
      for (std::size_t i = 0; i < width; ++i) {
        cells_[kept * width + i] = std::move(cells_[row * width + i]);
      }
      line_[kept] = line_[row];
    }
    ++kept;
  }
  const std::size_t dropped = num_rows() - kept;
  line_.resize(kept);
  cells_.resize(kept * width);
  return dropped;
}

std::vector<std::string> CsvTable::Texts(std::string_view column) const {
  const std::size_t index = PlaceOf(column).index;
  std::vector<std::string> values(num_rows());
  for (std::size_t row = 0; row < values.size(); ++row) {
    values[row] = cells_[row * columns_.size() + index];
  }
  return values;
}

std::string CsvTable::Where(std::size_t row) const {
  return Message(path_.string(), ":", line_.at(row));
}

std::string NumberText(double value) {
  ACUS_REQUIRE(std::isfinite(value), "a number to be written is not finite");
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  ACUS_ASSERT(error == std::errc());
  return {text.data(), end};
}

CsvWriter::CsvWriter(std::ostream& out, std::span<const std::string_view> columns)
    : out_(out), num_columns_(columns.size()) {
  for (std::size_t i = 0; i < columns.size(); ++i) out_ << (i == 0 ? "" : ",") << columns[i];
  out_ << '\n';
}

void CsvWriter::Row(std::span<const double> values) {
  ACUS_ASSERT(values.size() == num_columns_);
  line_.clear();
  for (const double value : values) {
    if (!line_.empty()) line_ += ',';
    line_ += NumberText(value);
  }
  out_ << line_ << '\n';
}

}  // namespace acus
