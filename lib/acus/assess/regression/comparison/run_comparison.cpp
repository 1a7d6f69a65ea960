#include "acus/assess/regression/comparison/run_comparison.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "acus/assess/regression/comparison/compare_metrics.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"
#include "acus/data/session/session_io.h"

namespace acus::comparison {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kForces = "forces.csv";
constexpr const char* kProbeForces = "probe_forces.csv";
constexpr const char* kImages = "images.igs.mha";
constexpr const char* kMetrics = "metrics.json";

/// Tables of a session or a run that are no results: recordings, lists, traces.
constexpr std::array<std::string_view, 8> kNoOutcome = {session::kNeedleFile,
                                                        session::kProbeFile,
                                                        session::kBreathingFile,
                                                        session::kCommandsFile,
                                                        session::kTrackerFile,
                                                        "events.csv",
                                                        "trace.csv",
                                                        "image_trace.csv"};

bool IsTableOverTime(const fs::path& file) {
  if (file.extension() != ".csv" || !fs::is_regular_file(file)) return false;
  if (std::ranges::find(kNoOutcome, file.filename().string()) != kNoOutcome.end()) return false;
  std::array<char, 7> begin{};
  std::ifstream(file, std::ios::binary).read(begin.data(), begin.size());
  return std::string_view(begin.data(), begin.size()) == "time_s,";
}

void RequireRun(const fs::path& run) {
  ACUS_REQUIRE(fs::is_directory(run), run.string(), ": is not a folder");
  ACUS_REQUIRE(!ComparableFiles(run).empty(), run.string(),
               ": is not a run folder of acus-replay, nor a session of acus-live; it has neither ",
               kForces, " nor ", kProbeForces, " nor ", kImages, " nor ", kMetrics);
}

/// Files that both runs have; adds those of only one to `comparison`.
std::vector<std::string> CommonFiles(RunComparison& comparison) {
  std::vector<std::string> in_b = ComparableFiles(comparison.run_b);
  std::vector<std::string> common;
  for (const std::string& name : ComparableFiles(comparison.run_a)) {
    const auto found = std::ranges::find(in_b, name);
    if (found == in_b.end()) {
      comparison.checks.push_back(OnlyInOne(name, "only in A"));
      continue;
    }
    common.push_back(name);
    in_b.erase(found);
  }
  for (const std::string& name : in_b) comparison.checks.push_back(OnlyInOne(name, "only in B"));
  return common;
}

void Append(const std::vector<Check>& from, std::vector<Check>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

/// The quantities of tables other than the force log begin with the table's name.
void CompareTables(const fs::path& a, const fs::path& b, const ForceTolerances& tolerances,
                   RunComparison& comparison) {
  if (a.filename() == kForces) {
    comparison.forces = CompareForces(CsvTable(a), CsvTable(b), tolerances);
    Append(comparison.forces.checks, comparison.checks);
    return;
  }
  const std::string table = a.stem().string();
  ForceComparison other = CompareForces(CsvTable(a), CsvTable(b), tolerances, table);
  for (Check& check : other.checks) {
    if (!check.quantity.starts_with(table + ": ")) check.quantity.insert(0, table + ": ");
    comparison.checks.push_back(std::move(check));
  }
}

void SetAsideWhatOneHas(RunComparison& comparison) {
  const auto others = std::ranges::stable_partition(
      comparison.checks, [](const Check& check) { return !check.only_in_one; });
  comparison.only_in_one.assign(others.begin(), others.end());
  comparison.checks.erase(others.begin(), others.end());
}

/// "images.igs.mha (only in B)"
std::string OnlyInOneText(const RunComparison& comparison) {
  if (comparison.only_in_one.empty()) return "";
  std::vector<std::string> texts;
  for (const Check& check : comparison.only_in_one) {
    texts.push_back(Message(check.quantity, " (", check.remark, ")"));
  }
  return Message("Not compared: ", Joined(texts), "\n");
}

std::string Short(const std::optional<double>& value) {
  return value ? RoundedText(*value, 4) : "-";
}

json OrNull(const std::optional<double>& value) {
  return value ? json(*value) : json(nullptr);
}

}  // namespace

bool RunComparison::passed() const {
  return std::ranges::all_of(checks, [](const Check& check) { return check.passed; });
}

std::vector<std::string> RunComparison::failed() const {
  std::vector<std::string> names;
  for (const Check& check : checks) {
    if (!check.passed) names.push_back(check.quantity);
  }
  return names;
}

std::vector<std::string> ComparableFiles(const fs::path& run) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(run)) {
    if (IsTableOverTime(entry.path())) names.push_back(entry.path().filename().string());
  }
  std::ranges::sort(names);
  // A broken force log also counts: its reader reports the problem.
  for (const char* name : {kMetrics, kImages, kProbeForces, kForces}) {
    std::erase(names, name);
    if (fs::exists(run / name)) names.insert(names.begin(), name);
  }
  return names;
}

RunComparison CompareRuns(const fs::path& run_a, const fs::path& run_b,
                          const Tolerances& tolerances, Lack lack, const RunContext& context) {
  RequireRun(run_a);
  RequireRun(run_b);
  RunComparison comparison;
  comparison.run_a = run_a;
  comparison.run_b = run_b;
  const std::vector<std::string> files = CommonFiles(comparison);
  ACUS_REQUIRE(lack == Lack::kFails || !files.empty(), run_a.string(), " and ", run_b.string(),
               ": have nothing in common to compare; A has ", Joined(ComparableFiles(run_a)),
               ", B has ", Joined(ComparableFiles(run_b)));
  for (const std::string& name : files) {
    const fs::path a = run_a / name;
    const fs::path b = run_b / name;
    if (name == kImages) {
      comparison.images = CompareImages(a, b, tolerances.images, context);
      Append(comparison.images.checks, comparison.checks);
    } else if (name == kMetrics) {
      Append(CompareMetrics(config::ReadJson(a), a.string(), config::ReadJson(b), b.string(),
                            tolerances.metrics),
             comparison.checks);
    } else {
      context.Checkpoint(name, 0.0);
      CompareTables(a, b, tolerances.forces, comparison);
    }
  }
  if (lack == Lack::kIsStated) SetAsideWhatOneHas(comparison);
  return comparison;
}

std::string TableText(const RunComparison& comparison) {
  std::vector<std::vector<std::string>> rows;
  for (const Check& check : comparison.checks) {
    const std::string limit =
        check.limit ? (check.at_least ? ">= " : "<= ") + Short(check.limit) : "same";
    rows.push_back({check.passed ? "ok" : "FAIL", check.quantity, Short(check.value), limit,
                    check.unit, check.remark});
  }
  const auto failed = comparison.failed().size();
  return TextTable({"", "quantity", "value", "limit", "unit", "A | B"}, rows) +
         Message("\nA: ", comparison.run_a.string(), "\nB: ", comparison.run_b.string(), "\n",
                 OnlyInOneText(comparison), failed == 0 ? "The runs agree" : "The runs DIFFER",
                 ": ", comparison.checks.size() - failed, " of ", comparison.checks.size(),
                 " checks passed.\n");
}

json ToJson(const RunComparison& comparison) {
  json checks = json::array();
  for (const Check& check : comparison.checks) {
    checks.push_back({{"quantity", check.quantity},
                      {"unit", check.unit},
                      {"value", OrNull(check.value)},
                      {"limit", OrNull(check.limit)},
                      {"relation", !check.limit     ? "same"
                                   : check.at_least ? "at least"
                                                    : "at most"},
                      {"passed", check.passed},
                      {"remark", check.remark}});
  }
  json only_in_one = json::array();
  for (const Check& check : comparison.only_in_one) {
    only_in_one.push_back({{"quantity", check.quantity}, {"remark", check.remark}});
  }
  json images = nullptr;
  if (const auto& worst = comparison.images.worst) {
    const FrameDifference& frame = comparison.images.frames[*worst];
    images = {{"num_compared", comparison.images.frames.size()},
              {"num_identical", comparison.images.num_identical},
              {"worst_frame",
               {{"number", *worst},
                {"time_s", frame.time_s},
                {"psnr_db", OrNull(frame.psnr_db)},
                {"ssim", frame.ssim}}}};
  }
  return {{"format", "acus-comparison/1"},
          {"passed", comparison.passed()},
          {"run_a", comparison.run_a.string()},
          {"run_b", comparison.run_b.string()},
          {"checks", checks},
          {"only_in_one", only_in_one},
          {"images", images}};
}

}  // namespace acus::comparison
