// A curriculum: exercises in order, which are open to a trainee, and which are mastered.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "acus/assess/study/study_data.h"

namespace acus::study {

struct CurriculumStep {
  std::string exercise;            ///< Its name, as training.json has it.
  std::filesystem::path file;      ///< Of the exercise.
  std::vector<std::size_t> after;  ///< Places of the steps that must be mastered before.
  double score_percent = 90.0;
  double goals_met_percent = 100.0;
  int in_a_row = 2;
  std::optional<double> time_limit_s;  ///< Of a session.
};

struct Curriculum {
  std::string name;
  std::vector<CurriculumStep> steps;
};

/// Reads an acus-curriculum file and the exercises that it names.
/// @throws InputError listing what is wrong: keys, ranges, an exercise twice, an entry that is no
///     earlier step.
Curriculum ReadCurriculum(const std::filesystem::path& path);

/// How far a trainee is with a step.
struct StepState {
  int trials = 0;
  double best_score_percent = 0.0;
  int longest_row = 0;  ///< Of trials that meet the criteria.
  bool mastered = false;
  bool open = true;  ///< All steps that must come before are mastered.
};

/// One for each step. Trials are those of one trainee, in order; others are skipped.
std::vector<StepState> ProgressOf(const Curriculum& curriculum, const std::string& code,
                                  std::span<const TrialRecord> trials);

/// A table for each code, and the step that is next.
std::string CurriculumText(const Curriculum& curriculum, std::span<const TrialRecord> trials,
                           const std::set<std::string>& codes);

/// The same for other programs: name, steps (exercise, file, after, mastery, time limit) and, for
/// each code, next (the place of a step from 0, or null) and the state of each step.
nlohmann::json CurriculumJson(const Curriculum& curriculum, std::span<const TrialRecord> trials,
                              const std::set<std::string>& codes);

}  // namespace acus::study
