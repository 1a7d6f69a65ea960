// The tables of a study as CSV. Names of columns: docs/reference/formats_runs.md.
#pragma once

#include <string>

#include "acus/assess/study/analysis.h"

namespace acus::study {

std::string DescriptiveCsv(const StudyAnalysis& analysis);
std::string ComparisonCsv(const StudyAnalysis& analysis);
std::string LearningCsv(const StudyAnalysis& analysis);
std::string ReliabilityCsv(const StudyAnalysis& analysis);
std::string ItemsCsv(const Study& study, const StudyAnalysis& analysis);
std::string AnswersCsv(std::span<const Answer> answers);

}  // namespace acus::study
