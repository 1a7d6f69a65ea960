// What a run of the stability suite left behind: bounds, plots and notes of the tests, and which
// tests passed.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "acus/base/report/svg_plot.h"

namespace acus::stability_page {

/// Where a record comes from.
struct Origin {
  std::string module;
  std::string suite;
  std::string test;
  std::string file;
  std::string hard;  ///< What is hard about it, one sentence.

  /// "Step size does not matter" of the test StepSizeDoesNotMatter; with "in tissue levels plane"
  /// of its suite where the module has another test of that name.
  std::string Name() const;

  bool shares_name = false;
};

/// One measured value and what it is held to.
struct BoundedValue {
  Origin origin;
  std::string quantity;
  std::string unit;
  std::string sense;  ///< <, <=, >, >= or ==.
  double bound = 0.0;
  double measured = 0.0;  ///< NaN for whatever is not finite.
  bool holds = false;

  /// How many times farther the value could be off: bound / measured, or the other way round where
  /// the bound is a least value. Infinite at 0, 1 for an equality that holds.
  double Margin() const;
};

struct OriginPlot {
  Origin origin;
  report::Plot plot;
};

struct Note {
  Origin origin;
  std::string name;
  std::string value;
};

/// A test of a program, as GoogleTest tells.
struct TestOutcome {
  std::string program;
  std::string suite;
  std::string test;
  bool skipped = false;
  double seconds = 0.0;
  std::string message;  ///< Of its failures; empty if it passed.
};

/// A program of tests as the pipeline saw it.
struct ProgramRun {
  std::string program;
  int exit_code = 0;
  double seconds = 0.0;
};

struct StabilityRun {
  std::vector<BoundedValue> values;  ///< By module, then as they were stated; the latest of each.
  std::vector<OriginPlot> plots;
  std::vector<Note> notes;
  std::vector<TestOutcome> tests;
  std::vector<ProgramRun> programs;
  std::string settings;  ///< "short", or how the run was asked for.

  std::vector<const BoundedValue*> Failing() const;
  std::vector<const TestOutcome*> FailedTests() const;
  /// Programs that ended with an error that none of their tests tells: a crash, a time-out.
  std::vector<const ProgramRun*> Crashed() const;
  bool AllHold() const;
  /// Modules of the values, in order.
  std::vector<std::string> Modules() const;
};

/// Reads `folder`/bounds/*.jsonl, `folder`/tests/*.json and `folder`/programs.jsonl.
/// @throws InputError naming file and line of what is not such a record, or if there is none.
StabilityRun ReadStabilityRun(const std::filesystem::path& folder);

}  // namespace acus::stability_page
