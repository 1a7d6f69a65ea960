#include "stability_page/stability_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/machine.h"
#include "acus/base/report/html_report.h"

namespace acus::stability_page {
namespace {

using nlohmann::json;
using Row = std::vector<std::string>;

std::string Short(double value) {
  if (!std::isfinite(value)) return std::isnan(value) ? "not a number" : "infinite";
  std::ostringstream out;
  out.precision(3);
  out << value;
  return out.str();
}

std::string SignOf(const std::string& sense) {
  if (sense == "<=") return "≤";
  if (sense == ">=") return "≥";
  return sense == "==" ? "=" : sense;
}

std::string WithUnit(const std::string& number, const std::string& unit) {
  return unit.empty() ? number : number + " " + unit;
}

std::string BoundText(const BoundedValue& value) {
  return SignOf(value.sense) + " " + WithUnit(Short(value.bound), value.unit);
}

std::string MarginText(const BoundedValue& value) {
  if (!value.holds) return "none";
  if (value.sense == "==") return "exact";
  const double margin = value.Margin();
  // A bound of zero, or a value on the good side of it.
  if (!std::isfinite(margin) || margin < 1.0) return "all";
  if (margin > 1e4) return "> 10000 x";
  return Short(margin) + " x";
}

std::string StatusText(const BoundedValue& value) {
  return value.holds ? "holds" : "FAILS";
}

/// One row per value; what is hard stands once for each test.
std::vector<Row> RowsOf(const std::vector<const BoundedValue*>& values) {
  std::vector<Row> rows;
  std::string last;
  for (const BoundedValue* value : values) {
    const std::string test = value->origin.suite + "." + value->origin.test;
    const bool is_new = test != last;
    last = test;
    rows.push_back({is_new ? value->origin.Name() : "", is_new ? value->origin.hard : "",
                    value->quantity, WithUnit(Short(value->measured), value->unit),
                    BoundText(*value), MarginText(*value), StatusText(*value)});
  }
  return rows;
}

const Row& Header() {
  static const Row header = {"case",  "what is hard", "quantity", "measured",
                             "bound", "margin",       "status"};
  return header;
}

std::vector<const BoundedValue*> OfModule(const StabilityRun& run, const std::string& module) {
  std::vector<const BoundedValue*> values;
  for (const BoundedValue& value : run.values) {
    if (value.origin.module == module) values.push_back(&value);
  }
  return values;
}

/// The value that could be off least, of those with a margin; null if there is none.
const BoundedValue* Tightest(const std::vector<const BoundedValue*>& values) {
  const BoundedValue* tightest = nullptr;
  for (const BoundedValue* value : values) {
    const double margin = value->Margin();
    if (value->sense == "==" || !std::isfinite(margin) || margin < 1.0) continue;
    if (tightest == nullptr || margin < tightest->Margin()) tightest = value;
  }
  return tightest;
}

int NumTests(const std::vector<const BoundedValue*>& values) {
  std::vector<std::string> tests;
  for (const BoundedValue* value : values) {
    tests.push_back(value->origin.suite + "." + value->origin.test);
  }
  std::ranges::sort(tests);
  return static_cast<int>(std::ranges::unique(tests).begin() - tests.begin());
}

void AddFailures(const StabilityRun& run, report::HtmlReport& page) {
  if (run.AllHold()) return;
  page.Section("What fails");
  if (const auto failing = run.Failing(); !failing.empty()) {
    page.Table(Header(), RowsOf(failing));
  }
  std::vector<Row> rows;
  for (const TestOutcome* test : run.FailedTests()) {
    rows.push_back({test->program, test->suite + "." + test->test, test->message});
  }
  for (const ProgramRun* program : run.Crashed()) {
    rows.push_back({program->program, "-",
                    Message("ended with exit code ", program->exit_code,
                            " and no test says why: a crash or a time-out")});
  }
  if (!rows.empty()) page.Table({"program", "test", "message"}, rows);
}

void AddOverview(const StabilityRun& run, report::HtmlReport& page) {
  page.Section("Overview");
  std::vector<Row> rows;
  for (const std::string& module : run.Modules()) {
    const auto values = OfModule(run, module);
    const auto failing =
        std::ranges::count_if(values, [](const BoundedValue* value) { return !value->holds; });
    const BoundedValue* tightest = Tightest(values);
    rows.push_back({module, std::to_string(NumTests(values)), std::to_string(values.size()),
                    std::to_string(failing), tightest == nullptr ? "-" : MarginText(*tightest),
                    tightest == nullptr ? "-" : tightest->quantity});
  }
  page.Table({"module", "hard cases", "values", "failing", "least margin", "of"}, rows,
             "Margin: how many times farther a value could be off before its bound is broken.");
  if (run.programs.empty()) return;
  rows.clear();
  for (const ProgramRun& program : run.programs) {
    const auto tests = std::ranges::count_if(run.tests, [&](const TestOutcome& test) {
      return test.program == program.program && !test.skipped;
    });
    rows.push_back({program.program, std::to_string(tests), Short(program.seconds),
                    std::to_string(program.exit_code)});
  }
  page.Table({"program", "tests run", "time [s]", "exit code"}, rows);
}

void AddNotes(const StabilityRun& run, report::HtmlReport& page) {
  if (run.notes.empty()) return;
  page.Section("What was run at random, and for how long");
  std::vector<Row> rows;
  for (const Note& note : run.notes) rows.push_back({note.origin.Name(), note.name, note.value});
  page.Table({"case", "what", "how much"}, rows);
}

json OriginJson(const Origin& origin) {
  return {{"module", origin.module},
          {"case", origin.Name()},
          {"test", origin.suite + "." + origin.test},
          {"file", origin.file},
          {"what_is_hard", origin.hard}};
}

json NumberJson(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

/// A text in a cell of a Markdown table.
std::string Cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) {
    text.replace(at, 1, "\\|");
  }
  std::ranges::replace(text, '\n', ' ');
  return text;
}

std::string Summary(const StabilityRun& run) {
  std::vector<const BoundedValue*> all;
  for (const BoundedValue& value : run.values) all.push_back(&value);
  const auto failing = run.Failing().size();
  return Message(NumTests(all), " hard cases, ", all.size(), " values with bounds, ",
                 failing == 0 ? std::string("all hold") : Message(failing, " do not hold"));
}

}  // namespace

std::string MachineText() {
  const Machine machine = ThisMachine();
  return Message(machine.processor, ", ", machine.threads, " cores, ",
                 std::lround(machine.memory_gb), " GB, ", machine.system);
}

std::string StabilityPage(const StabilityRun& run, const Provenance& provenance) {
  report::HtmlReport page("Numerical stability: hard cases", Summary(run));
  std::vector<std::string> warnings;
  for (const BoundedValue* value : run.Failing()) {
    warnings.push_back(Message(value->origin.module, ", ", value->origin.Name(), ": ",
                               value->quantity, " ", WithUnit(Short(value->measured), value->unit),
                               ", bound ", BoundText(*value)));
  }
  for (const TestOutcome* test : run.FailedTests()) {
    warnings.push_back("test fails: " + test->suite + "." + test->test);
  }
  for (const ProgramRun* program : run.Crashed()) {
    warnings.push_back("program ended early: " + program->program);
  }
  if (!warnings.empty()) page.Warnings(warnings);
  const std::vector<std::pair<std::string, std::string>> about = {
      {"run", run.settings.empty() ? "by hand" : run.settings},
      {"machine", MachineText()},
      {"version", provenance.version}};
  page.KeyValues(about);
  AddFailures(run, page);
  AddOverview(run, page);
  AddNotes(run, page);
  for (const std::string& module : run.Modules()) {
    page.Section(module);
    page.Table(Header(), RowsOf(OfModule(run, module)));
    for (const OriginPlot& plot : run.plots) {
      if (plot.origin.module != module) continue;
      page.Plots(std::span(&plot.plot, 1), plot.origin.Name() + ". " + plot.origin.hard);
    }
  }
  page.SetProvenance(provenance.ToJson());
  return page.Text();
}

json StabilityJson(const StabilityRun& run, const Provenance& provenance) {
  json out = {{"format", "acus-stability/1"}, {"provenance", provenance.ToJson()},
              {"machine", MachineText()},     {"settings", run.settings},
              {"all_hold", run.AllHold()},    {"values", json::array()},
              {"notes", json::array()},       {"failed_tests", json::array()},
              {"programs", json::array()}};
  for (const BoundedValue& value : run.values) {
    json entry = OriginJson(value.origin);
    entry.update({{"quantity", value.quantity},
                  {"unit", value.unit},
                  {"measured", NumberJson(value.measured)},
                  {"sense", value.sense},
                  {"bound", NumberJson(value.bound)},
                  {"margin", NumberJson(value.Margin())},
                  {"holds", value.holds}});
    out["values"].push_back(std::move(entry));
  }
  for (const Note& note : run.notes) {
    json entry = OriginJson(note.origin);
    entry.update({{"name", note.name}, {"value", note.value}});
    out["notes"].push_back(std::move(entry));
  }
  for (const TestOutcome* test : run.FailedTests()) {
    out["failed_tests"].push_back({{"program", test->program},
                                   {"test", test->suite + "." + test->test},
                                   {"message", test->message}});
  }
  for (const ProgramRun& program : run.programs) {
    out["programs"].push_back({{"program", program.program},
                               {"exit_code", program.exit_code},
                               {"seconds", program.seconds}});
  }
  return out;
}

std::string StabilityTable(const StabilityRun& run, const Provenance& provenance) {
  std::ostringstream out;
  out << "# Hard cases and their bounds\n\n"
         "<!-- Made by developer/stability --docs. -->\n\n"
      << Summary(run) << ". How to run this, read it and add to it: "
      << "[stability](concepts/stability.md).\n\nRun: "
      << (run.settings.empty() ? "by hand" : run.settings) << "; " << MachineText() << "; version "
      << provenance.version
      << ". Margin: how many times farther a value could be off before its bound is broken; "
         "\"exact\" for equalities, \"all\" where the value is zero.\n";
  for (const std::string& module : run.Modules()) {
    out << "\n## " << module << "\n\n| case | quantity | measured | bound | margin |\n"
        << "|---|---|---|---|---|\n";
    for (const Row& row : RowsOf(OfModule(run, module))) {
      const std::string name = row[0].empty() ? "" : "**" + row[0] + "** " + row[1];
      out << "| " << Cell(name) << " | " << Cell(row[2]) << " | " << Cell(row[3]) << " | "
          << Cell(row[4]) << " | " << Cell(row[5]) << " |\n";
    }
  }
  if (run.notes.empty()) return out.str();
  out << "\n## What was run at random, and for how long\n\n| case | what | how much "
         "|\n|---|---|---|\n";
  for (const Note& note : run.notes) {
    out << "| " << Cell(note.origin.Name()) << " | " << Cell(note.name) << " | " << Cell(note.value)
        << " |\n";
  }
  return out.str();
}

void WriteStability(const std::filesystem::path& folder, const StabilityRun& run,
                    const Provenance& provenance) {
  WriteTextFile(folder / "stability.html", StabilityPage(run, provenance));
  WriteTextFile(folder / "stability.json", StabilityJson(run, provenance).dump(2) + "\n");
}

}  // namespace acus::stability_page
