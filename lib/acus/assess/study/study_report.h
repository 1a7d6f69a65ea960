// The report of a study: tables as CSV, box plots, one page.
#pragma once

#include <filesystem>

#include "acus/assess/study/analysis.h"

namespace acus::study {

/// Writes into an existing folder: trials.csv and answers.csv (the inputs), descriptive.csv,
/// comparison.csv, learning.csv, reliability.csv, items.csv, study.html with box plots, and
/// provenance.json. A report of the written trials.csv and answers.csv has the same tables, byte
/// for byte.
void WriteStudyReport(const std::filesystem::path& folder, const Study& study,
                      std::span<const TrialRecord> trials, std::span<const Answer> answers,
                      const StudyAnalysis& analysis, const RunContext& context);

/// For the terminal: the inputs, and for each exercise how many metrics separate the groups and
/// which do not.
std::string StudyText(const Study& study, std::span<const TrialRecord> trials,
                      const StudyAnalysis& analysis);

}  // namespace acus::study
