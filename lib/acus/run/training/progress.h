// Compares the sessions of trainees: the progress from one to the next.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/run/training/assessment.h"

namespace acus::report {
class HtmlReport;
}

namespace acus::training {

/// Reads training.json of each run folder, in the given order: that of the sessions.
/// @throws InputError naming the folder that has none and how to create it, or the first one whose
///     exercise differs from that of the first.
std::vector<Assessment> ReadAssessments(std::span<const std::filesystem::path> runs);

/// For the terminal: one line per session with the values of all goals; unmet goals are marked.
std::string ProgressText(std::span<const Assessment> sessions);

/// Writes progress.csv (one row per session, a column per metric), progress.html with a plot per
/// goal, a line per trainee, and provenance.json into an existing folder.
/// @param add_sections  Adds sections to the page before the plots; may be empty.
void WriteProgress(const std::filesystem::path& folder, std::span<const Assessment> sessions,
                   const RunContext& context,
                   const std::function<void(report::HtmlReport&)>& add_sections = {});

}  // namespace acus::training
