#include "acus/assess/study/cases.h"

#include <algorithm>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/run/training/exercise.h"

namespace acus::study {
namespace {

namespace fs = std::filesystem;

const Case& LeastDone(std::span<const Case> cases, const std::string& code,
                      std::span<const CaseTrial> trials) {
  const auto rank = [&](const Case& one) {
    const auto done = std::ranges::count(trials, one.exercise, &CaseTrial::exercise);
    return std::pair(done, RandomStream(trials.size(), Message(code, '/', one.exercise)).Next());
  };
  return *std::ranges::min_element(cases, {}, rank);
}

const Case& OnStaircase(std::span<const Case> cases, std::span<const CaseTrial> trials) {
  std::size_t at = 0;
  for (const CaseTrial& trial : trials) {
    const auto found = std::ranges::find(cases, trial.exercise, &Case::exercise);
    if (found == cases.end()) continue;
    const auto done = static_cast<std::size_t>(found - cases.begin());
    at = trial.succeeded ? std::min(done + 1, cases.size() - 1)
                         : done - std::min<std::size_t>(done, 1);
  }
  return cases[at];
}

}  // namespace

std::vector<Case> ReadCases(const fs::path& path, const DifficultyRange& range) {
  const CsvTable table(path);
  const auto files = table.Texts("exercise");
  const auto difficulties = table.Numbers("difficulty");
  std::vector<Case> cases;
  std::set<std::string> names;
  for (std::size_t row = 0; row < table.num_rows(); ++row) {
    const double difficulty = difficulties[row];
    ACUS_REQUIRE(difficulty >= 0.0 && difficulty <= 1.0, table.Where(row), ": difficulty is ",
                 difficulty, "; it must be from 0 to 1");
    const fs::path file = config::FindConfig(files[row], fs::absolute(path).parent_path());
    const std::string name = training::ReadExercise(file).name;
    ACUS_REQUIRE(names.insert(name).second, table.Where(row),
                 ": another row has an exercise named \"", name,
                 "\", too; give each a name of its own");
    if (difficulty >= range.from && difficulty <= range.to)
      cases.push_back({name, file, difficulty});
  }
  ACUS_REQUIRE(!cases.empty(), path.string(), ": no case has a difficulty from ", range.from,
               " to ", range.to, "; widen the range");
  std::ranges::stable_sort(cases, {}, &Case::difficulty);
  return cases;
}

const Case& NextCase(std::span<const Case> cases, CaseOrder order, const std::string& code,
                     std::span<const CaseTrial> trials) {
  return order == CaseOrder::kStaircase ? OnStaircase(cases, trials)
                                        : LeastDone(cases, code, trials);
}

}  // namespace acus::study
