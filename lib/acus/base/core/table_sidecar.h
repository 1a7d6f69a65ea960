// The JSON file that describes a table, beside it and of the same name, as BIDS has them.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace acus {

struct TableSidecar {
  std::filesystem::path path;                ///< Empty if there is none.
  std::vector<std::string> columns;          ///< Names, of a table that has no row of them.
  std::map<std::string, std::string> units;  ///< By the name of the column.
  std::optional<double> rate_hz;             ///< Of the rows.
  double start_s = 0.0;                      ///< Of the first row.
};

/// The sidecar of a .tsv file: "Columns", "SamplingFrequency" and "StartTime" of recordings, and
/// "Units" of columns. Empty for other tables.
/// @throws InputError naming the sidecar if it is no JSON, or a value of these keys is of another
///     kind.
TableSidecar SidecarOf(const std::filesystem::path& table);

/// The rows of a table with the time of each as first cell.
std::string WithTimes(const std::string& text, double rate_hz, double start_s);

}  // namespace acus
