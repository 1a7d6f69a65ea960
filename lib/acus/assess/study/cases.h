// Cases of an exercise by difficulty, and the choice of a trainee's next case.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace acus::study {

/// One exercise in one patient.
struct Case {
  std::string exercise;        ///< Its name, as in training.json.
  std::filesystem::path file;  ///< File of the exercise.
  double difficulty = 0.0;     ///< From 0, easy, to 1.
};

struct DifficultyRange {
  double from = 0.0;
  double to = 1.0;
};

/// The rule for the next case.
enum class CaseOrder {
  kLeastDone,  ///< The one done least often; ties are broken at random.
  kStaircase,  ///< A harder one after a success, an easier one after a failure, from the easiest.
};

/// Reads a table with the columns exercise (a file, relative to the table) and difficulty.
/// @returns Those in the range, the easiest first; equal ones in the order of the table.
/// @throws InputError with file and row: a difficulty that is not in [0, 1], two exercises of one
///     name, no case in the range.
std::vector<Case> ReadCases(const std::filesystem::path& table, const DifficultyRange& range);

/// A trial of one of the cases.
struct CaseTrial {
  std::string exercise;
  bool succeeded = false;
};

/// The staircase is the simple up-down method (Levitt 1971): it converges to where half of the
/// trials succeed.
/// @param trials  Trials of one trainee, in order of time; those of other exercises are skipped.
/// @param code  Code of the trainee: the key of the random choice, with the number of trials.
/// @pre cases is not empty.
const Case& NextCase(std::span<const Case> cases, CaseOrder order, const std::string& code,
                     std::span<const CaseTrial> trials);

}  // namespace acus::study
