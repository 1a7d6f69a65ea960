// Rows of a sweep as files: tradeoff.csv, tradeoff.json, tradeoff.svg and
// tradeoff_preparation.svg, tradeoff.html.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "benchmarks/sweep.h"

namespace acus::benchmarks {

/// Header and one line per row; what was not measured is an empty cell.
std::string CsvText(const std::vector<Row>& rows);

/// The rows on a terminal, one table per knob.
std::string TableText(const std::vector<Row>& rows);

/// Runs a sweep and writes these files and provenance.json; the folder appears whole or not at
/// all. @returns the rows.
/// @throws NoAnswerError if no row may be used.
std::vector<Row> SweepToFolder(const Sweep& sweep, bool quick, const std::filesystem::path& folder,
                               const RunContext& context);

}  // namespace acus::benchmarks
