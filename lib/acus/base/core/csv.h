// CSV with a header row of names with units. Every problem is reported as file:row.
#pragma once

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <map>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acus/base/core/delimited_text.h"

namespace acus {

/// A whole table in memory, column access by name. Encodings, separators, quotes and decimal commas
/// as in delimited_text.h; empty lines and comments are skipped. The header is the last row of
/// names before the numbers, so that a preamble is skipped; a row of units below it is taken as
/// units.
class CsvTable {
 public:
  /// @throws InputError if the file cannot be read, has no header, a name twice, or a row with
  ///     another number of cells than the header.
  explicit CsvTable(const std::filesystem::path& path);

  /// A file without a header row, its columns named by the caller. A header that is there all the
  /// same is skipped.
  CsvTable(const std::filesystem::path& path, std::initializer_list<std::string_view> columns);

  const std::filesystem::path& path() const { return path_; }
  const std::vector<std::string>& columns() const { return columns_; }
  std::size_t num_rows() const { return line_.size(); }
  /// Whether there is a column of this name, or of the same words and another unit of the same
  /// kind: "Force [kN]" for "force_n".
  bool Has(std::string_view column) const;

  /// The cells of a column as finite numbers, in the unit of the requested name.
  /// @throws InputError if there is no such column, two of them, or at the first cell that is not a
  ///     number.
  std::vector<double> Numbers(std::string_view column) const;

  /// Omits the rows in which one of these columns is empty or "NaN". @returns how many.
  /// @throws InputError if there is no such column.
  std::size_t DropRowsWithout(std::span<const std::string_view> columns);

  /// Where there is no column of this name, the one that is called by one of these words is taken
  /// for it, if it has a unit of the same kind. @param words  As ColumnName::words.
  /// @throws InputError if there are two, or its unit is not said.
  void Accept(std::string_view column, std::span<const std::string_view> words);
  /// Takes the column of a name (with or without its unit), or of a number from 1, for `column`.
  /// @param unit  What it is in; empty: as its name or the row of units says.
  /// @throws InputError if there is no such column, or its unit is not known.
  void Take(std::string_view column, std::string_view name_or_number, std::string_view unit);

  /// What was taken where the file is not plain CSV: separators, skipped rows; otherwise empty.
  const std::string& how_read() const { return how_read_; }
  /// "force_n from 'Load_kN'"; empty if a column has the requested name.
  std::string Taken(std::string_view column) const;

  /// The cells of a column as text. @throws InputError if there is no such column.
  std::vector<std::string> Texts(std::string_view column) const;

  /// "file.csv:17", for messages about row `row` (0-based, of num_rows()).
  std::string Where(std::size_t row) const;

 private:
  struct Line {
    std::string_view text;
    std::size_t number = 0;  ///< From 1.
  };
  /// A column and what its numbers are multiplied by.
  struct Place {
    std::size_t index = 0;
    double factor = 1.0;
  };

  void Parse(std::string bytes, bool has_header);
  std::size_t TakeHeader(std::span<const Line> lines);
  void TakeUnits(std::span<const std::string> units);
  void AddRow(const Line& line, bool is_last_and_open);
  void Split(std::string_view line, std::vector<std::string>& cells) const;
  bool HasNumber(std::span<const std::string> cells) const;
  std::vector<Place> PlacesOf(std::string_view column) const;
  Place PlaceOf(std::string_view column) const;
  Place InUnitOf(std::string_view column, std::size_t index, std::string_view unit) const;

  std::filesystem::path path_;
  TableStyle style_;
  std::string how_read_;
  std::vector<std::string> columns_;
  std::map<std::string, Place, std::less<>> given_;  ///< Taken for other names.
  std::vector<std::string> cells_;                   ///< num_rows() x columns, row by row.
  std::vector<std::size_t> line_;                    ///< 1-based line in the file, by row.
  std::vector<std::string> row_;                     ///< Of the line that is being read.
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
