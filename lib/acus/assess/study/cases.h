// Cases of an exercise by difficulty, and which one a trainee gets next.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace acus::study {

/// One exercise in one patient.
struct Case {
  std::string exercise;        ///< Its name, as training.json has it.
  std::filesystem::path file;  ///< Of the exercise.
  double difficulty = 0.0;     ///< From 0, easy, to 1.
};

struct DifficultyRange {
  double from = 0.0;
  double to = 1.0;
};

/// How the next case is chosen.
enum class CaseOrder {
  kLeastDone,  ///< The one done least often; ties are broken by chance.
  kStaircase,  ///< A harder one after a success, an easier one after a failure, from the easiest.
};

/// Reads a table with the columns exercise (a file, relative to the table) and difficulty.
/// @returns Those in the range, the easiest first; equal ones in the order of the table.
/// @throws InputError with file and row: a difficulty that is not in [0, 1], two exercises of one
///     name, none in the range.
std::vector<Case> ReadCases(const std::filesystem::path& table, const DifficultyRange& range);

/// A trial of one of the cases.
struct CaseTrial {
  std::string exercise;
  bool succeeded = false;
};

/// The staircase is the simple up-down method (Levitt 1971): it settles where half of the trials
/// succeed. @param trials  Of one trainee, in order of time; those of other exercises are skipped.
/// @param code  Of the trainee: keys the chance, with the number of trials.
/// @pre cases is not empty.
const Case& NextCase(std::span<const Case> cases, CaseOrder order, const std::string& code,
                     std::span<const CaseTrial> trials);

}  // namespace acus::study
