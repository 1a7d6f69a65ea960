#include "acus/assess/regression/regression.h"

#include <algorithm>
#include <map>

#include "acus/assess/regression/calibration.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/run/replay/replay.h"

namespace acus::regression {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kTiming = "timing.json";

std::optional<Timing> ReadTiming(const fs::path& path) {
  if (!fs::exists(path)) return std::nullopt;
  const json document = config::ReadJson(path);
  try {
    const Timing timing{document.at("cpu_s"), document.at("calibration_s")};
    ACUS_REQUIRE(timing.cpu_s >= 0.0 && timing.calibration_s > 0.0, path.string(),
                 ": times must be positive");
    return timing;
  } catch (const json::exception& error) {
    throw InputError(
        Message(path.string(), ": is not a timing of acus-regression: ", error.what()));
  }
}

/// More CPU time than allowed is a failed check; less passes.
comparison::Check TimeCheck(const Timing& expected, const Timing& now, const Suite& suite) {
  const double percent = 100.0 * (now.Ratio() / expected.Ratio() - 1.0);
  const std::string remark = Message(RoundedText(expected.Ratio(), 3), " | ",
                                     RoundedText(now.Ratio(), 3), " calibration loops");
  if (expected.cpu_s < suite.time_min_s) {
    return comparison::Verdict("CPU time", true, remark + ", too short to be judged");
  }
  return comparison::AtMost("CPU time, more than expected", "%", percent, suite.time_percent,
                            remark);
}

/// The changed quantities of a case in the form of regression.json: "quantity: old | new".
std::string ChangesText(const json& result, const std::string& name) {
  for (const json& c : result.at("cases")) {
    if (c.at("name") != name) continue;
    if (c.at("comparison").is_null()) return name + ": had no expected outcome, has one now\n";
    std::string text;
    for (const json& check : c.at("comparison").at("checks")) {
      if (check.at("passed").get<bool>()) continue;
      const std::string remark = check.at("remark");
      const json& value = check.at("value");
      text += Message("  ", check.at("quantity").get<std::string>(), ": ",
                      value.is_null() ? ""
                                      : RoundedText(value.get<double>(), 4) + " " +
                                            check.at("unit").get<std::string>(),
                      remark.empty() ? "" : "  ", remark, "\n");
    }
    return text.empty() ? name + ": was as expected\n" : name + ": old | new\n" + text;
  }
  return "";
}

/// Replays into `run`, with a separate provenance.
Timing Replay(const Case& c, const fs::path& run, const RunContext& suite_context) {
  RunContext context = suite_context;
  context.provenance.input_sha256.clear();
  context.overwrite = false;
  const auto scenario = scenario::ReadScenario(c.scenario, c.changes);
  context.provenance.AddInput(c.scenario);
  replay::ReplayOptions options;
  options.run_folder = run;
  options.film = false;
  const double before_s = CalibrationSeconds();
  replay::ReplaySession(scenario, c.session, options, context);
  const double after_s = CalibrationSeconds();
  const Timing timing{config::ReadJson(run / "run.json").at("cpu_seconds"),
                      std::min(before_s, after_s)};
  config::WriteJson(run / kTiming,
                    {{"cpu_s", timing.cpu_s}, {"calibration_s", timing.calibration_s}});
  return timing;
}

void Compare(const Suite& suite, const Case& c, const fs::path& run, CaseResult& result,
             const RunContext& context) {
  const fs::path expected = suite.ExpectedOf(c);
  if (!fs::exists(expected)) {
    result.verdict = Verdict::kNew;
    return;
  }
  result.comparison = comparison::CompareRuns(
      expected, run, comparison::ReadTolerances(c.tolerances), comparison::Lack::kFails, context);
  result.expected_timing = ReadTiming(expected / kTiming);
  if (result.expected_timing) {
    result.comparison->checks.push_back(TimeCheck(*result.expected_timing, result.timing, suite));
  }
  result.verdict = result.comparison->passed() ? Verdict::kSame : Verdict::kMoved;
}

}  // namespace

bool SuiteResult::passed() const {
  return std::ranges::all_of(cases, [](const auto& c) { return c.verdict == Verdict::kSame; });
}

SuiteResult RunSuite(const Suite& suite, const fs::path& folder, RunContext& context) {
  SuiteResult results{suite.folder, suite.description, suite.set, {}};
  for (const Case& c : suite.cases) {
    context.Checkpoint(c.name, static_cast<double>(results.cases.size()) /
                                   static_cast<double>(suite.cases.size()));
    CaseResult result;
    result.name = c.name;
    const fs::path run = folder / c.name / "run";
    try {
      fs::create_directories(run.parent_path());
      result.timing = Replay(c, run, context);
      Compare(suite, c, run, result, context);
    } catch (const InputError& error) {
      result.verdict = Verdict::kNoResult;
      result.message = error.what();
    }
    results.cases.push_back(std::move(result));
  }
  return results;
}

std::string AcceptResult(const Suite& suite, const fs::path& result_folder) {
  ACUS_REQUIRE(fs::exists(result_folder / "regression.json"), result_folder.string(),
               ": is not a result of acus-regression run");
  const json result = config::ReadJson(result_folder / "regression.json");
  ACUS_REQUIRE(result.value("suite", "") == suite.folder.string(), result_folder.string(),
               ": is a result of ", result.value("suite", "another suite"), ", not of ",
               suite.folder.string());
  const json set = result.value("set", json::array());
  ACUS_REQUIRE(set.empty(), result_folder.string(), ": is a result with --set ",
               set.empty() ? "" : set.front().dump(),
               ", which the suite does not have; run it without, or put the change into the suite");
  for (const Case& c : suite.cases) {
    ACUS_REQUIRE(fs::exists(result_folder / c.name / "run" / "run.json"), result_folder.string(),
                 ": has no run of ", c.name, "; it ended with an error, or was not requested");
  }
  std::map<std::string, std::string> texts;
  try {
    for (const Case& c : suite.cases) texts[c.name] = ChangesText(result, c.name);
  } catch (const json::exception& error) {
    throw InputError(Message((result_folder / "regression.json").string(),
                             ": is not as acus-regression run wrote it: ", error.what()));
  }
  std::string text;
  for (const Case& c : suite.cases) {
    AtomicFolder expected(suite.ExpectedOf(c), /*overwrite=*/true);
    fs::copy(result_folder / c.name / "run", expected.path(),
             fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    expected.Commit();
    text += texts[c.name];
  }
  return text;
}

}  // namespace acus::regression
