#include "acus/assess/regression/regression_report.h"

#include <algorithm>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/counted.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"
#include "acus/base/report/html_report.h"
#include "acus/base/report/markup.h"

namespace acus::regression {
namespace {

namespace fs = std::filesystem;
using comparison::Check;
using nlohmann::json;

const char* WordOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kSame:
      return "same";
    case Verdict::kMoved:
      return "MOVED";
    case Verdict::kNew:
      return "NEW";
    case Verdict::kNoResult:
      return "NO RESULT";
  }
  return "";
}

std::string FirstTrouble(const CaseResult& result) {
  if (result.verdict == Verdict::kNoResult) return result.message;
  if (result.verdict == Verdict::kNew) return "nothing is expected of it yet";
  const auto failed = result.comparison->failed();
  if (failed.empty()) return "";
  return failed.size() == 1 ? failed.front()
                            : Message(failed.front(), " and ", failed.size() - 1, " more");
}

std::string ChecksText(const CaseResult& result) {
  if (!result.comparison) return "-";
  const auto& checks = result.comparison->checks;
  return Message(checks.size() - result.comparison->failed().size(), " of ", checks.size());
}

std::string TimeText(const CaseResult& result) {
  if (!result.expected_timing) return "-";
  return RoundedText(result.timing.Ratio() / result.expected_timing->Ratio(), 3);
}

const std::vector<std::string> kHeader = {"verdict", "case", "checks passed", "time / expected",
                                          "what moved"};

std::vector<std::vector<std::string>> Rows(const SuiteResult& result) {
  std::vector<std::vector<std::string>> rows;
  for (const CaseResult& c : result.cases) {
    rows.push_back({WordOf(c.verdict), c.name, ChecksText(c), TimeText(c), FirstTrouble(c)});
  }
  return rows;
}

std::string SummaryOf(const SuiteResult& result) {
  const auto num_same = std::ranges::count(result.cases, Verdict::kSame, &CaseResult::verdict);
  const auto count = static_cast<std::int64_t>(result.cases.size());
  return Message(num_same, " of ", Counted(count, "case"), count == 1 ? " is" : " are",
                 " as expected.");
}

std::string NumberOrDash(const std::optional<double>& value) {
  return value ? RoundedText(*value, 4) : "-";
}

/// Forces of a column that failed a check, expected and current, one above the other.
void AddMovedForces(const comparison::RunComparison& compared, report::HtmlReport& html) {
  for (const comparison::ForcePair& pair : compared.forces.forces) {
    const bool moved = std::ranges::any_of(compared.checks, [&pair](const Check& check) {
      return !check.passed && check.quantity.starts_with(pair.column + ":");
    });
    if (!moved) continue;
    report::Plot plot;
    plot.title = pair.column;
    plot.x_label = "time [s]";
    plot.y_label = "force [N]";
    plot.height_px = 220;
    plot.series = {{.name = "expected", .x = compared.forces.time_s, .y = pair.a_n},
                   {.name = "now", .x = compared.forces.time_s, .y = pair.b_n}};
    html.Plots(std::vector{plot});
  }
}

void AddMoved(const fs::path& folder, const CaseResult& result, report::HtmlReport& html) {
  html.Section(result.name);
  if (!result.comparison) {
    html.Paragraph(FirstTrouble(result));
    return;
  }
  std::vector<std::vector<std::string>> rows;
  for (const Check& check : result.comparison->checks) {
    if (check.passed) continue;
    rows.push_back({check.quantity, NumberOrDash(check.value),
                    check.limit
                        ? (check.at_least ? "at least " : "at most ") + NumberOrDash(check.limit)
                        : "same",
                    check.unit, check.remark});
  }
  html.Table({"quantity", "value", "limit", "unit", "expected | now"}, rows);
  AddMovedForces(*result.comparison, html);
  const fs::path image = folder / result.name / "comparison" / "worst_frame.png";
  const auto& images = result.comparison->images;
  if (images.num_identical < images.frames.size() && fs::exists(image)) {
    html.Image(image, "The image that differs most: expected, now and their difference",
               "The image that differs most: expected | now | difference");
  }
  html.Paragraph(Message("All checks: ", result.name, "/comparison/comparison.html"));
}

json ToJson(const SuiteResult& result) {
  json cases = json::array();
  for (const CaseResult& c : result.cases) {
    json entry = {{"name", c.name},
                  {"verdict", WordOf(c.verdict)},
                  {"message", FirstTrouble(c)},
                  {"cpu_s", c.timing.cpu_s},
                  {"calibration_s", c.timing.calibration_s},
                  {"comparison", nullptr}};
    if (c.comparison) entry["comparison"] = comparison::ToJson(*c.comparison);
    cases.push_back(std::move(entry));
  }
  return {{"format", "acus-regression-result/1"},
          {"suite", result.suite_folder.string()},
          {"set", result.set},
          {"passed", result.passed()},
          {"cases", cases}};
}

}  // namespace

std::string TextOf(const SuiteResult& result) {
  return TextTable(kHeader, Rows(result)) + SummaryOf(result) + "\n";
}

void WriteResult(const fs::path& folder, const SuiteResult& result, const RunContext& context) {
  for (const CaseResult& c : result.cases) {
    if (!c.comparison) continue;
    const fs::path own = folder / c.name / "comparison";
    fs::create_directories(own);
    comparison::WriteComparison(own, *c.comparison, context);
  }
  report::HtmlReport html("Regression of recorded sessions", result.description);
  html.Section("Cases");
  html.Paragraph(SummaryOf(result));
  if (!result.set.empty()) html.Paragraph("Changed for this run: " + Joined(result.set));
  html.Table(kHeader, Rows(result),
             "Time in units of a calibration loop on the same machine, so that another machine can "
             "be compared with.");
  for (const CaseResult& c : result.cases) {
    if (c.verdict != Verdict::kSame) AddMoved(folder, c, html);
  }
  html.SetProvenance(context.provenance.ToJson());
  html.Write(folder / "regression.html");
  json document = ToJson(result);
  document["provenance"] = context.provenance.ToJson();
  config::WriteJson(folder / "regression.json", document);
  config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
}

void WriteJUnit(const fs::path& file, const SuiteResult& result) {
  using report::Escaped;
  const auto count = [&result](std::initializer_list<Verdict> verdicts) {
    return std::ranges::count_if(result.cases, [verdicts](const CaseResult& c) {
      return std::ranges::find(verdicts, c.verdict) != verdicts.end();
    });
  };
  const std::string suite = Escaped(
      result.description.empty() ? result.suite_folder.filename().string() : result.description);
  std::string text = Message("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n",
                             "<testsuite name=\"", suite, "\" tests=\"", result.cases.size(),
                             "\" failures=\"", count({Verdict::kMoved, Verdict::kNew}),
                             "\" errors=\"", count({Verdict::kNoResult}), "\">\n");
  for (const CaseResult& c : result.cases) {
    text += Message("<testcase classname=\"", suite, "\" name=\"", Escaped(c.name), "\" time=\"",
                    FixedText(c.timing.cpu_s, 3), "\">");
    if (c.verdict != Verdict::kSame) {
      const char* tag = c.verdict == Verdict::kNoResult ? "error" : "failure";
      const std::string all = c.comparison ? Joined(c.comparison->failed(), "\n") : FirstTrouble(c);
      text += Message("<", tag, " type=\"", WordOf(c.verdict), "\" message=\"",
                      Escaped(FirstTrouble(c)), "\">", Escaped(all), "</", tag, ">");
    }
    text += "</testcase>\n";
  }
  WriteTextFile(file, text + "</testsuite>\n</testsuites>\n");
}

std::string AdviceText(const SuiteResult& result) {
  if (!result.set.empty()) {
    return Message("with ", Joined(result.set),
                   " the outcome is not the one without; that is what ",
                   "this change does, and cannot be accepted");
  }
  return "the outcome is not what is expected; look at the page, and if it is right, "
         "acus-regression accept makes it the expected one";
}

}  // namespace acus::regression
