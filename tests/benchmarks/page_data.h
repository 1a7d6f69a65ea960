// What pages about measurements are made from: rows of sweeps and single facts, stored as files.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "benchmarks/sweep.h"

namespace acus::benchmarks {

/// One number of a row, by its name in a template: "error N" (of rows whose error_unit is N),
/// "step_us_median", "step_us_p999", "preparation_s", "memory_mb", or "value" where that is a
/// number; with a factor before it: "1000 * error N".
class RowField {
 public:
  /// @throws InputError for a name that is none of these.
  explicit RowField(std::string_view text);

  /// Whether the row has it: all do, unless it is an error of another unit.
  bool IsOf(const Row& row) const;
  /// NaN if it was not measured. @pre IsOf(row)
  double Of(const Row& row) const;

 private:
  double factor_ = 1.0;
  std::string name_;
  std::string unit_;
};

/// Sweeps by name, in the order of their rows, and facts by file and key.
struct PageData {
  std::map<std::string, std::vector<Row>> sweeps;
  std::map<std::string, nlohmann::json> facts;  ///< Objects of numbers and texts.

  /// Every NAME.csv of a folder (as acus-tradeoff writes it) and every NAME.json.
  /// @throws InputError if there are none, or one cannot be read.
  static PageData Read(const std::filesystem::path& folder);

  /// @throws InputError that lists the sweeps.
  const std::vector<Row>& Sweep(const std::string& name) const;

  /// What a selector names: "FILE | key" a fact, "SWEEP | knob | value | field" a field of rows;
  /// the value may be "default", "paper" or "*", all that may be used. Rows of errors in several
  /// units repeat the rest: of each value the first counts. Empty if nothing was measured.
  /// @throws InputError if the selector has another form, or its sweep, file or knob is not there.
  std::vector<double> Numbers(std::string_view selector) const;

  /// A fact as text; numbers as JSON shows them. @throws InputError if it is not there.
  std::string Text(std::string_view selector) const;
};

/// Rows as acus-tradeoff writes them. @throws InputError naming file and row.
std::vector<Row> ReadRows(const std::filesystem::path& csv);

/// The parts between '|', without blanks around them.
std::vector<std::string> Parts(std::string_view text, char separator = '|');

}  // namespace acus::benchmarks
