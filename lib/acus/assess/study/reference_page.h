// Texts, tables and pages of a comparison with a reference group.
#pragma once

#include <string>

#include "acus/assess/study/reference_group.h"
#include "acus/base/report/html_report.h"

namespace acus::study {

/// For the terminal: a row for each goal.
std::string ReferenceText(const GroupComparison& comparison);

/// reference.csv: a row for each metric.
std::string ReferenceCsv(const GroupComparison& comparison);

/// A section: the table, and a strip for each goal with the group's persons, the interval of their
/// mean, the trainee's earlier sessions and the newest one.
void AddReferenceSection(const GroupComparison& comparison, report::HtmlReport& report);

/// Makes a folder with the content of training::WriteProgress, with the section and reference.csv
/// if there is a group. @throws InputError as AtomicFolder.
void WriteProgress(const std::filesystem::path& folder,
                   std::span<const training::Assessment> sessions,
                   const std::optional<GroupComparison>& group, const RunContext& context);

}  // namespace acus::study
