// Rows of an append-only CSV, in which a crash may have cut off the last line.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "acus/base/core/run_context.h"

namespace acus::session {

/// Reads the lines of one file one after the other. Columns are found by name, in any order, among
/// others; empty lines and lines that begin with '#' are skipped. Encodings, separators and decimal
/// commas as in delimited_text.h. A line ends with a word of a fixed set in its
/// last column: without it, a line that has no end was being written when the recording stopped,
/// and is omitted with a warning.
class CsvRows {
 public:
  static constexpr std::size_t kMaxColumns = 40;

  /// @param columns  All columns, the one with the word last. At most kMaxColumns. As `words`, it
  ///     must outlive this.
  /// @throws InputError if the file cannot be read.
  CsvRows(const std::filesystem::path& path, std::span<const std::string_view> columns,
          std::span<const std::string_view> words, const RunContext& context);

  /// The next row; false at the end.
  /// @throws InputError at file:row, if the header is another one, a cell is missing, or the last
  ///     one has none of the words.
  bool Next();

  /// A cell of the present row.
  std::string_view Cell(std::size_t column) const { return cells_[column]; }
  /// Index in `words` of the last cell.
  std::size_t Word() const { return word_; }

  /// The cell as a number. @throws InputError if it is none, or not finite.
  double Number(std::size_t column) const;
  /// The cell as a time. @throws InputError if it is none, or before that of the row before.
  std::int64_t TimeNs(std::size_t column);
  /// Whether the row has the time of the row before: a sample that was stored twice.
  bool IsRepeated() const { return is_repeated_; }

  std::string Where() const;  ///< "file.csv:17".
  /// Bytes of the file, to guess the number of rows.
  std::size_t size() const { return text_.size(); }

 private:
  using Cells = std::array<std::string_view, kMaxColumns>;
  void ReadHeader(std::string_view line);
  bool ReadRow(std::string_view line, bool is_complete);
  std::string Header() const;

  std::string name_;
  const RunContext& context_;
  std::span<const std::string_view> columns_;
  std::span<const std::string_view> words_;
  std::string text_;
  std::size_t begin_ = 0;
  std::size_t line_number_ = 0;
  std::array<std::size_t, kMaxColumns> place_{};
  bool has_header_ = false;
  Cells cells_{};
  std::size_t word_ = 0;
  std::size_t num_cells_ = 0;  ///< Of the header.
  bool is_repeated_ = false;
  std::optional<std::int64_t> last_time_ns_;
};

}  // namespace acus::session
