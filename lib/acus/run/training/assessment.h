// The assessment of a session by an exercise: metrics and goals.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "acus/run/training/exercise.h"
#include "acus/run/training/metric.h"
#include "acus/run/training/session_metrics.h"

namespace acus::training {

struct GoalResult {
  Goal goal;
  std::string unit;
  /// Nothing if it was not reached, or no insertion was made: such a goal is not met.
  std::optional<double> value;
  bool met = false;
};

struct Assessment {
  std::string exercise;
  std::string trainee;  ///< A code, not a name; may be empty.
  std::string session;
  std::vector<Metric> metrics;
  std::vector<GoalResult> goals;
  std::vector<NamedStructure> structures;  ///< Structures on the path of the tip.
  std::string target = {};                 ///< Its name; empty: the exercise has none.
  double target_radius_mm = 0.0;
  std::vector<StepResult> checklist = {};
  bool by_virtual_trainee = false;  ///< Simulated: no person did it.

  std::size_t NumMet() const;
  bool Passed() const;  ///< True if all goals with `must` are met.
};

/// False if the metrics state that the needle made no pass in tissue.
bool HasInsertion(const std::vector<Metric>& metrics);

/// False for a goal of an insertion that was not made: it is neither met nor missed.
bool IsJudged(const Assessment& assessment, const GoalResult& result);

/// The result of the insertion, in a sentence: "Target reached: the tip ended 2.1 mm from the
/// L3/L4 space (at most 3 mm)." Without an insertion: "No insertion: ...".
std::string OutcomeText(const Assessment& assessment);

/// A goal for kTimeToTarget is not met if the target was not reached. Without an insertion only
/// goals of the probe are judged: an attempt that ends outside the tissue has no value.
/// @throws InputError if the session has no metric of a goal's name; lists those that it has.
std::vector<GoalResult> JudgeGoals(const std::vector<Goal>& goals,
                                   const std::vector<Metric>& metrics);

/// "Passed.", or "Failed: tip to target at the end: 21 mm, required at most 3 mm." with each must
/// that is not met. Empty without goals.
std::string VerdictText(const Assessment& assessment);

/// "at most 3 mm", "at least 70 %, at most 90 %".
std::string GoalText(const Goal& goal, const std::string& unit);

/// Outcome, verdict, "Goals met: 5 of 6", then a line for each goal that was not. Ends with '\n'.
std::string GoalsText(const Assessment& assessment);

/// training.json, format acus-training/1.
nlohmann::json ToJson(const Assessment& assessment);

/// Reads training.json. @throws InputError if it is not such a file.
Assessment ReadAssessment(const std::filesystem::path& path);

}  // namespace acus::training
