#include "acus/data/session/csv_rows.h"

#include <algorithm>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/delimited_text.h"
#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"
#include "acus/base/core/words.h"
#include "acus/data/session/pose_csv.h"

namespace acus::session {
namespace {

/// Splits into `cells` and returns how many there are, also when these are more.
std::size_t Split(std::string_view line, std::span<std::string_view> cells) {
  std::size_t count = 0;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    if (count < cells.size()) cells[count] = Trimmed(line.substr(begin, end - begin));
    ++count;
    begin = end + 1;
  }
  return count;
}

std::string List(std::span<const std::string_view> words, std::string_view separator) {
  std::string text;
  for (const std::string_view word : words) {
    if (!text.empty()) text += separator;
    text += word;
  }
  return text;
}

}  // namespace

CsvRows::CsvRows(const std::filesystem::path& path, std::span<const std::string_view> columns,
                 std::span<const std::string_view> words, const RunContext& context)
    : name_(path.string()),
      context_(context),
      columns_(columns),
      words_(words),
      text_(ReadTextFile(path)) {
  ACUS_ASSERT(columns.size() <= kMaxColumns);
  if (!text_.starts_with(Header())) text_ = AsPlainCsv(std::move(text_), name_);
  // After a power cut some file systems fill the end of a file with zero bytes.
  while (!text_.empty() && text_.back() == '\0') text_.pop_back();
}

std::string CsvRows::Where() const {
  return Message(name_, ":", line_number_);
}

std::string CsvRows::Header() const {
  return List(columns_, ",");
}

bool CsvRows::Next() {
  const std::string_view text = text_;
  while (begin_ < text.size()) {
    const std::size_t newline = text.find('\n', begin_);
    const std::size_t end = std::min(newline, text.size());
    const std::string_view line = Trimmed(text.substr(begin_, end - begin_));
    begin_ = end + 1;
    ++line_number_;
    if (line.empty() || line.front() == '#') continue;
    if (!has_header_) {
      ReadHeader(line);
    } else if (ReadRow(line, /*is_complete=*/newline != text.npos)) {
      return true;
    }
  }
  ACUS_REQUIRE(has_header_, name_, ": is empty; the first line must be ", Header());
  return false;
}

void CsvRows::ReadHeader(std::string_view line) {
  Cells cells;
  const std::size_t count = Split(line, cells);
  ACUS_REQUIRE(count <= kMaxColumns, Where(), ": the header has ", count, " columns; at most ",
               kMaxColumns, " are read: ", Header());
  num_cells_ = count;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const auto found = std::ranges::find(cells, columns_[i]);
    ACUS_REQUIRE(found != cells.end(), Where(), ": no column '", columns_[i],
                 "'; the header must be ", Header());
    place_[i] = static_cast<std::size_t>(found - cells.begin());
  }
  has_header_ = true;
}

bool CsvRows::ReadRow(std::string_view line, bool is_complete) {
  Cells in_file;
  const std::size_t count = Split(line, in_file);
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    cells_[i] = place_[i] < count ? in_file[place_[i]] : std::string_view();
  }
  const std::string_view last = cells_[columns_.size() - 1];
  const auto word = std::ranges::find(words_, last);
  const bool known = count == num_cells_ && word != words_.end();
  if (!is_complete && !known) {
    // The word ends a line, so a line without it was being written when the recording stopped.
    context_.Warn(Message(Where(),
                          ": the last line is cut off (was the recording interrupted?); "
                          "it is omitted"));
    return false;
  }
  ACUS_REQUIRE(count == num_cells_, Where(), ": has ", count, " cells, the columns are ",
               num_cells_, " (", Header(), num_cells_ > columns_.size() ? " and others)" : ")");
  ACUS_REQUIRE(known, Where(), ": ", columns_.back(), " is '", last,
               "'; allowed: ", List(words_, ", "));
  word_ = static_cast<std::size_t>(word - words_.begin());
  return true;
}

double CsvRows::Number(std::size_t column) const {
  const auto value = ParseFinite(cells_[column]);
  ACUS_REQUIRE(value.has_value(), Where(), ": ", columns_[column], " is '", cells_[column],
               "'; a finite number is needed");
  return *value;
}

std::int64_t CsvRows::TimeNs(std::size_t column) {
  const auto time_ns = NanosecondsFromText(cells_[column]);
  ACUS_REQUIRE(time_ns.has_value(), Where(), ": ", columns_[column], " is '", cells_[column],
               "'; a finite number of seconds within +-", kMaxTimeS, " is needed");
  is_repeated_ = last_time_ns_ && *time_ns == *last_time_ns_;
  ACUS_REQUIRE(!last_time_ns_ || *time_ns >= *last_time_ns_, Where(), ": ", columns_[column],
               " is ", cells_[column], ", but the sample before is at ",
               SecondsText(*last_time_ns_), "; time must increase: remove or sort the rows");
  last_time_ns_ = time_ns;
  return *time_ns;
}

}  // namespace acus::session
