// A sweep's result for people and programs: tradeoff.csv, tradeoff.json, a table, plain sentences.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/assess/tuning/sweep_plan.h"
#include "acus/assess/tuning/sweep_result.h"
#include "acus/base/core/run_context.h"

namespace acus::tuning {

/// One line per setting: means over repetitions and the half widths of their 95 % intervals
/// (columns that end in _ci95). What was not measured is an empty cell; so is the PSNR of identical
/// images, whose image_rms_grey is 0.
std::string CsvText(const SweepResult& result);

/// All of the result: knobs, settings with intervals, every run (format acus-tradeoff-scene/1).
nlohmann::json ToJson(const SweepResult& result);

/// The settings of one knob's sweep, for people.
struct KnobTable {
  std::string knob;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};
std::vector<KnobTable> TablesOf(const SweepResult& result);

/// Settings on a terminal, one table per knob.
std::string TableText(const SweepResult& result);

/// One plain sentence per knob: what is lost and gained between the scenario's own value (or the
/// cheap one of two) and the most expensive. "needle_nodes 15 instead of 50: force error 0.013 N
/// RMS, ..."
std::string Sentences(const SweepResult& result);

/// What was not swept, and why; empty if nothing was left out.
std::string LeftOutText(const SweepPlan& plan);

/// Writes tradeoff.csv, tradeoff.json and provenance.json into the sweep's folder.
void WriteResult(const std::filesystem::path& folder, const SweepResult& result,
                 const RunContext& context);

}  // namespace acus::tuning
