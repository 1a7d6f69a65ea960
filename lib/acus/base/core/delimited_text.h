// Tables in text files as programs and machines write them: encodings, separators, quotes and
// decimal commas.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace acus {

/// What stands between the cells of a table, and in its numbers.
struct TableStyle {
  char separator = ',';  ///< ',', ';', '\t', '|', or ' ' for any number of blanks.
  bool has_decimal_comma = false;

  bool IsPlain() const { return separator == ',' && !has_decimal_comma; }
  /// "semicolons, decimal comma".
  std::string Text() const;
};

/// UTF-8 of the bytes of a text file: without a byte order mark, and UTF-16 with one converted.
/// Lines that end with CR alone end with LF then.
/// @throws InputError naming `label` if UTF-16 is broken.
std::string Utf8Text(std::string bytes, const std::string& label);

/// The style of a table in UTF-8, found in its first lines that are no comments.
/// @throws InputError naming `label` and both readings, if a comma may separate cells or decimals.
TableStyle StyleOf(std::string_view text, const std::string& label);

/// Whether a line is a comment: it begins with '#', '%' or "//".
bool IsCommentLine(std::string_view line);

/// The cells of a line, without the blanks and quotes around them. Within quotes, a separator is
/// text and "" is a quotation mark.
void SplitCells(std::string_view line, char separator, std::vector<std::string>& cells);

/// The whole of a cell as a finite number; a '+' may lead.
std::optional<double> NumberInCell(std::string_view cell, bool has_decimal_comma);

/// Whether nothing was measured: an empty cell, "NaN", "NA", "N/A", "null" or "-".
bool IsMissingCell(std::string_view cell);

/// The name of a column with a unit, taken apart: "Force [N]", "Load_kN", "Time (Seconds)", "x_mm".
struct ColumnName {
  std::string words;  ///< In lower case, joined by '_'.
  std::string unit;   ///< In lower case, as written; empty if there is none.
};
ColumnName ParseColumnName(std::string_view name);

/// How many of the second unit one of the first is: 0.001 of "ms" and "s". Units of time, length
/// and force, in lower case. Nothing if they do not measure the same, or one is not known.
std::optional<double> UnitFactor(std::string_view from, std::string_view to);

/// Whether a text is a unit that UnitFactor has, alone or in brackets: of a row of units.
bool IsUnitCell(std::string_view cell);

/// The table as CSV: separated by commas, numbers with a point. A cell that holds a comma stays
/// quoted. For readers of plain CSV.
/// @returns the text itself if it is plain.
std::string AsPlainCsv(std::string text, const std::string& label);

}  // namespace acus
