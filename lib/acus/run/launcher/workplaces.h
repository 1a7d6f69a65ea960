// Workplaces of pipelines/live-session as their folders show them: nothing else is kept.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace acus::launcher {

struct ExerciseOfWorkplace {
  std::string file_name;  ///< Without ".json", as --exercise takes it.
  std::string title;
  std::string instructions;
};

struct Workplace {
  std::filesystem::path folder;
  std::string name;     ///< Of the folder.
  std::string patient;  ///< Name of the scenario.
  std::vector<ExerciseOfWorkplace> exercises;
  std::vector<std::string> trainees;  ///< Codes with sessions, sorted.
  std::string trouble;                ///< Why it cannot be used; empty: it can.
};

/// `folder` itself if it is a workplace, then those in it, sorted by name. A folder is a workplace
/// if it contains scenario.json. Files that cannot be read are reported in Workplace::trouble.
std::vector<Workplace> FindWorkplaces(const std::filesystem::path& folder);

/// A session of a trainee that has a report and was not discarded.
struct Trial {
  std::filesystem::path folder;
  std::string time;  ///< "2026-11-28 17:20".
  std::size_t goals_met = 0;
  std::size_t num_goals = 0;
  bool passed = false;
};

/// Oldest first. @param exercise  ExerciseOfWorkplace::file_name.
std::vector<Trial> TrialsOf(const Workplace& workplace, const std::string& trainee,
                            const std::string& exercise);

/// The page of a trainee's progress, whether or not it exists.
std::filesystem::path ProgressPage(const Workplace& workplace, const std::string& trainee,
                                   const std::string& exercise);

/// Whether pipelines/live-session takes it: letters, digits, '-' and '_'.
bool IsTraineeCode(const std::string& code);

}  // namespace acus::launcher
