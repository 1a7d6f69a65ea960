// CSV with a header row of names with units. Every problem is reported as file:row.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace acus {

/// A whole CSV file in memory, column access by name. Comma-separated, no quoting; empty lines and
/// lines that begin with '#' are skipped; CRLF is accepted.
class CsvTable {
 public:
  /// @throws InputError if the file cannot be read, has no header, a name twice, or a row with
  ///     another number of cells than the header.
  explicit CsvTable(const std::filesystem::path& path);

  /// A file without a header row, its columns named by the caller.
  CsvTable(const std::filesystem::path& path, std::initializer_list<std::string_view> columns);

  const std::filesystem::path& path() const { return path_; }
  const std::vector<std::string>& columns() const { return columns_; }
  std::size_t num_rows() const { return line_.size(); }
  bool Has(std::string_view column) const;

  /// The cells of a column as finite numbers.
  /// @throws InputError if there is no such column, or at the first cell that is not a number.
  std::vector<double> Numbers(std::string_view column) const;

  /// The cells of a column as text. @throws InputError if there is no such column.
  std::vector<std::string> Texts(std::string_view column) const;

  /// "file.csv:17", for messages about row `row` (0-based, of num_rows()).
  std::string Where(std::size_t row) const;

 private:
  void Parse(std::string_view text, bool has_header);
  std::size_t IndexOf(std::string_view column) const;

  std::filesystem::path path_;
  std::vector<std::string> columns_;
  std::vector<std::string> cells_;  ///< num_rows() x columns, row by row.
  std::vector<std::size_t> line_;   ///< 1-based line in the file, by row.
};

/// The shortest text that reads back as the same double. @throws InputError if it is not finite.
std::string NumberText(double value);

/// Writes a header and rows of numbers.
class CsvWriter {
 public:
  CsvWriter(std::ostream& out, std::span<const std::string_view> columns);
  /// @pre one value per column. @throws InputError if a value is not finite.
  void Row(std::span<const double> values);

 private:
  std::ostream& out_;
  std::size_t num_columns_;
  std::string line_;
};

}  // namespace acus
