// Output files and texts of a sweep: tradeoff.csv, tradeoff.json, a table, sentences.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/assess/tuning/sweep_plan.h"
#include "acus/assess/tuning/sweep_result.h"
#include "acus/base/core/run_context.h"

namespace acus::tuning {

/// One line per setting: means over repetitions and the half widths of their 95 % intervals
/// (columns that end in _ci95). Values that were not measured are empty cells; so is the PSNR of
/// identical images, whose image_rms_grey is 0.
std::string CsvText(const SweepResult& result);

/// All of the result: knobs, settings with intervals, every run (format acus-tradeoff-scene/1).
nlohmann::json ToJson(const SweepResult& result);

/// The settings of one parameter's sweep, as text.
struct KnobTable {
  std::string knob;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};
std::vector<KnobTable> TablesOf(const SweepResult& result);

/// Settings for the terminal, one table per parameter.
std::string TableText(const SweepResult& result);

/// One sentence per parameter: losses and gains between the scenario's own value (or the cheap one
/// of two) and the most expensive. "needle_nodes 15 instead of 50: force error 0.013 N RMS, ..."
std::string Sentences(const SweepResult& result);

/// Values that were not swept, and the reasons; empty if there are none.
std::string LeftOutText(const SweepPlan& plan);

/// Writes tradeoff.csv, tradeoff.json and provenance.json into the sweep's folder.
void WriteResult(const std::filesystem::path& folder, const SweepResult& result,
                 const RunContext& context);

}  // namespace acus::tuning
