#include "acus/assess/comparison/run_comparison.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "acus/assess/comparison/compare_metrics.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"

namespace acus::comparison {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kForces = "forces.csv";
constexpr const char* kImages = "images.igs.mha";
constexpr const char* kMetrics = "metrics.json";

void RequireRun(const fs::path& run) {
  ACUS_REQUIRE(fs::is_directory(run), run.string(), ": is not a folder");
  const auto is_there = [&run](const char* name) { return fs::exists(run / name); };
  ACUS_REQUIRE(is_there(kForces) || is_there(kImages) || is_there(kMetrics), run.string(),
               ": is not a run folder of acus-replay; it has neither ", kForces, " nor ", kImages,
               " nor ", kMetrics);
}

/// Whether both runs have the file; if only one has, that is a failed check.
bool BothHave(const char* name, RunComparison& comparison) {
  const bool in_a = fs::exists(comparison.run_a / name);
  const bool in_b = fs::exists(comparison.run_b / name);
  if (in_a != in_b) {
    comparison.checks.push_back(Verdict(name, false, in_a ? "only in A" : "only in B"));
  }
  return in_a && in_b;
}

void Append(const std::vector<Check>& from, std::vector<Check>& to) {
  to.insert(to.end(), from.begin(), from.end());
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

RunComparison CompareRuns(const fs::path& run_a, const fs::path& run_b,
                          const Tolerances& tolerances, const RunContext& context) {
  RequireRun(run_a);
  RequireRun(run_b);
  RunComparison comparison;
  comparison.run_a = run_a;
  comparison.run_b = run_b;
  if (BothHave(kForces, comparison)) {
    context.Checkpoint("forces", 0.0);
    comparison.forces =
        CompareForces(CsvTable(run_a / kForces), CsvTable(run_b / kForces), tolerances.forces);
    Append(comparison.forces.checks, comparison.checks);
  }
  if (BothHave(kImages, comparison)) {
    comparison.images = CompareImages(run_a / kImages, run_b / kImages, tolerances.images, context);
    Append(comparison.images.checks, comparison.checks);
  }
  if (BothHave(kMetrics, comparison)) {
    const fs::path a = run_a / kMetrics;
    const fs::path b = run_b / kMetrics;
    Append(CompareMetrics(config::ReadJson(a), a.string(), config::ReadJson(b), b.string(),
                          tolerances.metrics),
           comparison.checks);
  }
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
                 failed == 0 ? "The runs agree" : "The runs DIFFER", ": ",
                 comparison.checks.size() - failed, " of ", comparison.checks.size(),
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
          {"images", images}};
}

}  // namespace acus::comparison
