#include "stability_page/stability_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"

namespace acus::stability_page {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Files of a folder with an extension, by name; none if it is not there.
std::vector<fs::path> Files(const fs::path& folder, const char* extension) {
  std::vector<fs::path> files;
  if (!fs::is_directory(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == extension) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

/// Calls `use` with each line's JSON; names file and line of what is wrong.
template <typename Use>
void ForEachLine(const fs::path& file, const Use& use) {
  std::istringstream lines(ReadTextFile(file));
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    try {
      use(json::parse(line));
    } catch (const json::exception& error) {
      throw InputError(
          Message(file.string(), ":", number, ": not a record of a test: ", error.what()));
    }
  }
}

Origin OriginOf(const json& record) {
  return {.module = record.at("module"),
          .suite = record.at("suite"),
          .test = record.at("test"),
          .file = record.at("file"),
          .hard = record.at("hard"),
          .shares_name = false};
}

double NumberOr(const json& value, double otherwise) {
  return value.is_number() ? value.get<double>() : otherwise;
}

BoundedValue ValueOf(const json& record) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  return {.origin = OriginOf(record),
          .quantity = record.at("quantity"),
          .unit = record.at("unit"),
          .sense = record.at("sense"),
          .bound = NumberOr(record.at("bound"), kNone),
          .measured = NumberOr(record.at("measured"), kNone),
          .holds = record.at("holds")};
}

/// Points that a plot can show: finite, and positive on a logarithmic axis.
report::Plot PlotOf(const json& record) {
  report::Plot plot{.title = record.at("title"),
                    .x_label = record.at("x_label"),
                    .y_label = record.at("y_label"),
                    .log_x = record.at("log_x"),
                    .log_y = record.at("log_y")};
  for (const json& curve : record.at("curves")) {
    report::Series series{.name = curve.at("name")};
    const json& x = curve.at("x");
    const json& y = curve.at("y");
    for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) {
      if (!x[i].is_number() || !y[i].is_number()) continue;
      if (plot.log_x && x[i].get<double>() <= 0.0) continue;
      if (plot.log_y && y[i].get<double>() <= 0.0) continue;
      series.x.push_back(x[i]);
      series.y.push_back(y[i]);
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

/// Puts a record into a list; in the place of the one with the same key, if there is one.
template <typename Entry>
class Latest {
 public:
  explicit Latest(std::vector<Entry>& entries) : entries_(entries) {}

  /// Null if it is the first of its key.
  Entry* Find(const std::string& key) {
    const auto found = at_.find(key);
    return found == at_.end() ? nullptr : &entries_[found->second];
  }
  void Put(const std::string& key, Entry entry) {
    if (Entry* old = Find(key)) {
      *old = std::move(entry);
      return;
    }
    at_.emplace(key, entries_.size());
    entries_.push_back(std::move(entry));
  }

 private:
  std::vector<Entry>& entries_;
  std::map<std::string, std::size_t> at_;
};

/// What is stated more than once (in a loop, in a longer run): the last; of values one that fails.
void ReadBounds(const fs::path& file, StabilityRun& run) {
  Latest values(run.values);
  Latest plots(run.plots);
  Latest notes(run.notes);
  ForEachLine(file, [&](const json& record) {
    const std::string kind = record.at("kind");
    const Origin origin = OriginOf(record);
    const std::string test = origin.suite + "." + origin.test + "\n";
    if (kind == "plot") {
      report::Plot plot = PlotOf(record);
      const std::string key = test + plot.title;
      plots.Put(key, {origin, std::move(plot)});
    } else if (kind == "note") {
      const Note note{origin, record.at("name"), record.at("value")};
      notes.Put(test + note.name, note);
    } else if (kind == "bound") {
      const BoundedValue value = ValueOf(record);
      const std::string key = test + value.quantity;
      const BoundedValue* old = values.Find(key);
      if (old == nullptr || old->holds) values.Put(key, value);
    }
  });
}

void ReadTests(const fs::path& file, StabilityRun& run) {
  try {
    const json results = json::parse(ReadTextFile(file));
    for (const json& suite : results.at("testsuites")) {
      for (const json& test : suite.at("testsuite")) {
        const std::string seconds = test.at("time");
        TestOutcome outcome{.program = file.stem().string(),
                            .suite = suite.at("name"),
                            .test = test.at("name"),
                            .skipped = test.value("result", "") == "SKIPPED",
                            .seconds = std::strtod(seconds.c_str(), nullptr),
                            .message = ""};
        for (const json& failure : test.value("failures", json::array())) {
          outcome.message += failure.at("failure").get<std::string>() + "\n";
        }
        run.tests.push_back(std::move(outcome));
      }
    }
  } catch (const json::exception& error) {
    throw InputError(Message(file.string(), ": not a result of tests: ", error.what()));
  }
}

/// "Step size of 10 us" of StepSizeOf10Us; what follows a slash (a parameter) is left out.
std::string InWords(const std::string& name) {
  std::string words;
  for (std::size_t i = 0; i < name.size() && name[i] != '/'; ++i) {
    const char letter = name[i];
    const bool upper = letter >= 'A' && letter <= 'Z';
    const bool digit = letter >= '0' && letter <= '9';
    const bool after_digit = i > 0 && name[i - 1] >= '0' && name[i - 1] <= '9';
    if (i > 0 && (upper || (digit && !after_digit))) words += ' ';
    words += upper && i > 0 ? static_cast<char>(letter - 'A' + 'a') : letter;
  }
  return words;
}

/// Marks tests of one name in several suites of a module.
void MarkSharedNames(StabilityRun& run) {
  std::map<std::string, std::set<std::string>> suites;
  const auto key = [](const Origin& origin) {
    return origin.module + "." + origin.test.substr(0, origin.test.find('/'));
  };
  for (const BoundedValue& value : run.values) {
    const std::string& suite = value.origin.suite;
    suites[key(value.origin)].insert(suite.substr(0, suite.find('/')));
  }
  const auto mark = [&](Origin& origin) { origin.shares_name = suites[key(origin)].size() > 1; };
  for (BoundedValue& value : run.values) mark(value.origin);
  for (OriginPlot& plot : run.plots) mark(plot.origin);
  for (Note& note : run.notes) mark(note.origin);
}

}  // namespace

std::string Origin::Name() const {
  return shares_name ? InWords(test) + " (" + InWords(suite) + ")" : InWords(test);
}

double BoundedValue::Margin() const {
  if (sense == "==") return holds ? 1.0 : 0.0;
  const bool is_least = sense.front() == '>';
  const double over = is_least ? measured : bound;
  const double under = is_least ? bound : measured;
  return under == 0.0 ? std::numeric_limits<double>::infinity() : over / under;
}

std::vector<const BoundedValue*> StabilityRun::Failing() const {
  std::vector<const BoundedValue*> failing;
  for (const BoundedValue& value : values) {
    if (!value.holds) failing.push_back(&value);
  }
  return failing;
}

std::vector<const TestOutcome*> StabilityRun::FailedTests() const {
  std::vector<const TestOutcome*> failed;
  for (const TestOutcome& test : tests) {
    if (!test.message.empty()) failed.push_back(&test);
  }
  return failed;
}

std::vector<const ProgramRun*> StabilityRun::Crashed() const {
  std::set<std::string> tell;
  for (const TestOutcome* test : FailedTests()) tell.insert(test->program);
  std::vector<const ProgramRun*> crashed;
  for (const ProgramRun& program : programs) {
    if (program.exit_code != 0 && !tell.contains(program.program)) crashed.push_back(&program);
  }
  return crashed;
}

bool StabilityRun::AllHold() const {
  return Failing().empty() && FailedTests().empty() && Crashed().empty();
}

std::vector<std::string> StabilityRun::Modules() const {
  std::vector<std::string> modules;
  for (const BoundedValue& value : values) {
    if (std::ranges::find(modules, value.origin.module) == modules.end()) {
      modules.push_back(value.origin.module);
    }
  }
  return modules;
}

StabilityRun ReadStabilityRun(const fs::path& folder) {
  StabilityRun run;
  for (const fs::path& file : Files(folder / "bounds", ".jsonl")) ReadBounds(file, run);
  ACUS_REQUIRE(!run.values.empty(), (folder / "bounds").string(),
               ": no test stated a bound there; run developer/stability");
  MarkSharedNames(run);
  for (const fs::path& file : Files(folder / "tests", ".json")) ReadTests(file, run);
  if (fs::exists(folder / "programs.jsonl")) {
    ForEachLine(folder / "programs.jsonl", [&run](const json& record) {
      if (record.contains("settings")) {
        run.settings = record["settings"];
      } else {
        run.programs.push_back(
            {record.at("program"), record.at("exit_code"), record.at("seconds")});
      }
    });
  }
  return run;
}

}  // namespace acus::stability_page
