#include "acus/base/core/csv.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"
#include "acus/base/core/spelling.h"
#include "acus/base/core/words.h"

namespace acus {
namespace {

std::vector<std::string_view> Split(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    cells.push_back(Trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return cells;
}

}  // namespace

CsvTable::CsvTable(const std::filesystem::path& path) : path_(path) {
  Parse(ReadTextFile(path), /*has_header=*/true);
}

CsvTable::CsvTable(const std::filesystem::path& path,
                   std::initializer_list<std::string_view> columns)
    : path_(path), columns_(columns.begin(), columns.end()) {
  Parse(ReadTextFile(path), /*has_header=*/false);
}

void CsvTable::Parse(std::string_view text, bool has_header) {
  bool header_pending = has_header;
  std::size_t line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = Trimmed(text.substr(begin, end - begin));
    begin = end + 1;
    ++line_number;
    if (line.empty() || line.front() == '#') continue;
    ACUS_REQUIRE(line.find('\0') == line.npos, path_.string(), ":", line_number,
                 ": has a zero byte; this is not a CSV file");
    const auto cells = Split(line);
    if (header_pending) {
      header_pending = false;
      columns_.assign(cells.begin(), cells.end());
      auto sorted = columns_;
      std::ranges::sort(sorted);
      const auto twice = std::ranges::adjacent_find(sorted);
      ACUS_REQUIRE(twice == sorted.end(), path_.string(), ":", line_number, ": column '", *twice,
                   "' appears twice");
      continue;
    }
    ACUS_REQUIRE(cells.size() == columns_.size(), path_.string(), ":", line_number, ": has ",
                 cells.size(), " cells, the columns are ", columns_.size(), " (",
                 Joined(columns_, ","), "); is the file cut off?");
    cells_.insert(cells_.end(), cells.begin(), cells.end());
    line_.push_back(line_number);
  }
  ACUS_REQUIRE(!header_pending, path_.string(), ": is empty; a header row is needed");
}

bool CsvTable::Has(std::string_view column) const {
  return std::ranges::find(columns_, column) != columns_.end();
}

std::size_t CsvTable::IndexOf(std::string_view column) const {
  const auto found = std::ranges::find(columns_, column);
  if (found == columns_.end()) {
    const auto nearest = NearestSpelling(column, columns_);
    throw InputError(Message(path_.string(), ":1: no column '", column, "'; the header is ",
                             Joined(columns_, ","),
                             nearest ? Message("; rename '", *nearest, "'?") : std::string()));
  }
  return static_cast<std::size_t>(found - columns_.begin());
}

std::vector<double> CsvTable::Numbers(std::string_view column) const {
  const std::size_t index = IndexOf(column);
  std::vector<double> values(num_rows());
  for (std::size_t row = 0; row < values.size(); ++row) {
    const std::string& cell = cells_[row * columns_.size() + index];
    const auto value = ParseFinite(cell);
    ACUS_REQUIRE(value, Where(row), ": ", column, " is '", cell, "'; a finite number is needed");
    values[row] = *value;
  }
  return values;
}

std::vector<std::string> CsvTable::Texts(std::string_view column) const {
  const std::size_t index = IndexOf(column);
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
