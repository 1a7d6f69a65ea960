// Replays a suite and compares each run with the expected one.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acus/assess/regression/comparison/run_comparison.h"
#include "acus/assess/regression/suite.h"

namespace acus::regression {

/// The cost of a run, in a form that is comparable between machines.
struct Timing {
  double cpu_s = 0.0;
  double calibration_s = 0.0;

  double Ratio() const { return cpu_s / calibration_s; }
};

enum class Verdict {
  kSame,     ///< All checks passed.
  kMoved,    ///< A check failed.
  kNew,      ///< There is no expectation yet.
  kNoResult  ///< The replay ended with an error.
};

struct CaseResult {
  std::string name;
  Verdict verdict = Verdict::kNoResult;
  std::string message;                                  ///< Message of the error.
  std::optional<comparison::RunComparison> comparison;  ///< A: expected, B: now. Not for `kNew`.
  std::optional<Timing> expected_timing;
  Timing timing;
};

struct SuiteResult {
  std::filesystem::path suite_folder;
  std::string description;
  std::vector<std::string> set;  ///< Changes for this run alone.
  std::vector<CaseResult> cases;

  bool passed() const;
};

/// Replays every case into `folder`/<name>/run and compares the results and the CPU time with the
/// expected ones. A case that cannot be replayed does not stop the others.
/// @param folder  Exists.
SuiteResult RunSuite(const Suite& suite, const std::filesystem::path& folder, RunContext& context);

/// Makes the runs of an earlier result the expected ones: exactly the compared files, without
/// running anything again. Each expectation is replaced whole or not at all.
/// @returns the old and new expectations, case by case, as text.
/// @throws InputError if `result_folder` is no result of this suite, is one with changes for that
///     run alone, or has no run of a case.
std::string AcceptResult(const Suite& suite, const std::filesystem::path& result_folder);

}  // namespace acus::regression
