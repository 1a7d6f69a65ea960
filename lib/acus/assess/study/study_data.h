// The collected data of a study: trials with their metrics, and answers.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "acus/assess/study/study_file.h"
#include "acus/base/core/run_context.h"
#include "acus/run/training/assessment.h"

namespace acus::study {

/// One metric of all trials.
struct MetricKey {
  std::string name;
  std::string unit;  ///< Empty for a count.
  auto operator<=>(const MetricKey&) const = default;
};

/// "name [unit]", or the name alone.
std::string WithUnit(const MetricKey& metric);

struct TrialRecord {
  std::string code;
  std::string exercise;
  int trial = 1;  ///< From 1, in the order of the files.
  std::map<MetricKey, double> metrics;
  std::filesystem::path folder = {};  ///< Folder of its files; empty if it comes from a table.
  bool passed = true;                 ///< All goals of its exercise with `must` were met.
  bool by_virtual_trainee = false;    ///< True: simulated, not performed by a person.
};

struct Answer {
  std::string code;
  std::string questionnaire;
  std::string item;
  int answer = 0;  ///< 1 to the size of the scale.
};

/// The names of two metrics that every trial has besides those of its training.json.
inline constexpr const char* kGoalsMet = "goals met";  ///< Percent.
inline constexpr const char* kScore = "score";         ///< training::ScoreOf, in percent.

/// The metrics of a session, with kGoalsMet and kScore if it has goals; without folder and number.
TrialRecord RecordOf(const training::Assessment& assessment);

/// Reads trials: folders are searched for training.json at any depth; CSV files are tables in the
/// format of TrialsCsv. Trials of one participant in one exercise are numbered in the order of
/// their paths, with numbers by value. Sessions that were discarded (training/discarded.h) do not
/// count. Sorted by participant (as in the study), exercise and trial.
///
/// Trials without consent are not kept, with a warning. @throws InputError for a code or exercise
/// that the study does not list, or if there is no trial at all.
std::vector<TrialRecord> ReadTrials(std::span<const std::filesystem::path> paths,
                                    const Study& study, RunContext& context);

/// All trials of folders, numbered as by ReadTrials, of any trainees and exercises; empty if there
/// is none. @throws InputError if a training.json is broken.
std::vector<TrialRecord> FindTrials(std::span<const std::filesystem::path> folders,
                                    RunContext& context);

/// trials.csv: code,group,exercise,trial,metric,unit,value,virtual; a row per metric of each trial.
/// Reading it gives trials with the same bits.
std::string TrialsCsv(const Study& study, std::span<const TrialRecord> trials);

/// Reads code,questionnaire,item,answer; rows without an answer are skipped.
/// @throws InputError with file and row for an unknown code, questionnaire or item, an answer
///     outside the scale, or a second answer.
std::vector<Answer> ReadAnswers(const std::filesystem::path& path, const Study& study,
                                RunContext& context);

/// Reads code,consent,...: yes or no for each code, in place of the study's; the last row of a code
/// counts, and codes that are no participants are skipped.
/// @throws InputError with file and row for a value that is neither.
void ReadConsents(const std::filesystem::path& path, Study& study, RunContext& context);

/// Paths with numbers by value: trial_2 before trial_10.
bool NaturallyBefore(const std::string& a, const std::string& b);

}  // namespace acus::study
