// Replays a suite and holds each run against what is expected of it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acus/assess/regression/comparison/run_comparison.h"
#include "acus/assess/regression/suite.h"

namespace acus::regression {

/// What a run cost, in a form that another machine can be compared by.
struct Timing {
  double cpu_s = 0.0;
  double calibration_s = 0.0;

  double Ratio() const { return cpu_s / calibration_s; }
};

enum class Verdict {
  kSame,     ///< All checks passed.
  kMoved,    ///< Some did not.
  kNew,      ///< Nothing is expected of it yet.
  kNoResult  ///< The replay ended with an error.
};

struct CaseResult {
  std::string name;
  Verdict verdict = Verdict::kNoResult;
  std::string message;                                  ///< Of the error.
  std::optional<comparison::RunComparison> comparison;  ///< A: expected, B: now. Unless kNew.
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

/// Replays every case into `folder`/<name>/run and compares it with what is expected, its CPU time
/// too. A case that cannot be replayed does not keep the others from running.
/// @param folder  Exists.
SuiteResult RunSuite(const Suite& suite, const std::filesystem::path& folder, RunContext& context);

/// Makes the runs of an earlier result the expected ones: exactly what was looked at, without
/// running anything again. Each expectation is replaced whole or not at all.
/// @returns what was expected and what is from now on, case by case, as text.
/// @throws InputError if `result_folder` is no result of this suite, is one with changes for that
///     run alone, or has no run of a case.
std::string AcceptResult(const Suite& suite, const std::filesystem::path& result_folder);

}  // namespace acus::regression
