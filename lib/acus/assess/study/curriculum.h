// A curriculum: exercises in order, with those that are open to a trainee and those mastered.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "acus/assess/study/cases.h"
#include "acus/assess/study/study_data.h"

namespace acus::study {

struct CurriculumStep {
  std::string title;        ///< The exercise's name, or that of its cases.
  std::vector<Case> cases;  ///< At least one; an exercise is one case.
  CaseOrder order = CaseOrder::kLeastDone;
  std::vector<std::size_t> after;  ///< Indices of the steps that must be mastered before.
  double score_percent = 90.0;
  double goals_met_percent = 100.0;
  int in_a_row = 2;
  std::optional<double> time_limit_s;  ///< Limit of a session.

  /// Any trial meets the criteria: the step is done then, not mastered.
  bool RequiresNothing() const { return score_percent <= 0.0 && goals_met_percent <= 0.0; }
};

struct Curriculum {
  std::string name;
  std::vector<CurriculumStep> steps;
};

/// Reads an acus-curriculum file and the exercises that it names.
/// @throws InputError listing all problems: keys, ranges, an exercise twice, a step with an
///     exercise and cases or with neither, an entry that is no earlier step.
Curriculum ReadCurriculum(const std::filesystem::path& path);

/// A trainee's progress in a step.
struct StepState {
  int trials = 0;
  double best_score_percent = 0.0;
  int longest_row = 0;  ///< Largest number of consecutive trials that meet the criteria.
  bool mastered = false;
  bool open = true;  ///< All steps that must come before are mastered.
  Case next;         ///< Case of the trainee's next trial.
};

/// One for each step. Trials of others are skipped. Those of one exercise are in order; those of a
/// step with cases are sorted by their folders.
std::vector<StepState> ProgressOf(const Curriculum& curriculum, const std::string& code,
                                  std::span<const TrialRecord> trials);

/// A table for each code, and the next step.
std::string CurriculumText(const Curriculum& curriculum, std::span<const TrialRecord> trials,
                           const std::set<std::string>& codes);

/// The same as JSON: name, steps (exercise, number of cases, after, mastery, time limit) and, for
/// each code, next (the index of a step from 0, or null) and the state of each step with its next
/// case.
nlohmann::json CurriculumJson(const Curriculum& curriculum, std::span<const TrialRecord> trials,
                              const std::set<std::string>& codes);

}  // namespace acus::study
