// Text in a cell of CSV.
#pragma once

#include <algorithm>
#include <string>

namespace acus::study {

/// The text with semicolons in place of commas: CSV has no quotes here.
inline std::string CsvCell(std::string text) {
  std::ranges::replace(text, ',', ';');
  return text;
}

}  // namespace acus::study
