#include "acus/assess/regression/new_suite.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <memory>
#include <set>

#include "acus/assess/regression/comparison/tolerances.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/counted.h"
#include "acus/base/core/error.h"
#include "acus/run/replay/replay.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::regression {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// "PATH", relative to the suite in `folder`.
std::string PathFrom(const fs::path& folder, const fs::path& path) {
  return fs::absolute(path).lexically_normal().lexically_proximate(folder).string();
}

/// A preset keeps its name; a file becomes a path relative to the suite.
std::string ConfigFrom(const fs::path& folder, const fs::path& name) {
  const fs::path found = config::FindConfig(name, fs::current_path());
  const bool is_preset = name.is_relative() && found == config::ConfigsFolder() / name;
  return is_preset ? name.string() : PathFrom(folder, found);
}

/// A unique name for a case, from the allowed characters of the session's folder or file.
std::string NameOfCase(const fs::path& session, std::set<std::string>& taken) {
  const fs::path path = fs::absolute(session).lexically_normal();
  std::string name = (path.has_filename() ? path : path.parent_path()).filename().string();
  name = name.substr(0, name.find(".igs"));
  std::ranges::replace_if(
      name, [](unsigned char c) { return !std::isalnum(c) && c != '-' && c != '.'; }, '_');
  name.erase(0, name.find_first_not_of("_.-"));
  if (name.empty()) name = "session";
  std::string unique = name;
  for (int i = 2; !taken.insert(unique).second; ++i) unique = Message(name, "-", i);
  return unique;
}

/// Absolute paths of files in a value, at any depth, become relative to the suite.
void MakeRelative(json& value, const fs::path& folder) {
  if (value.is_structured()) {
    for (json& part : value) MakeRelative(part, folder);
  } else if (value.is_string()) {
    const fs::path path = value.get<std::string>();
    if (path.is_absolute() && fs::exists(path)) value = PathFrom(folder, path);
  }
}

/// "/pointer=value", with paths relative to the suite.
std::string ChangeFrom(const fs::path& folder, const std::string& text) {
  scenario::Override change =
      scenario::ForAnyFolder(scenario::ParseOverride(text), fs::current_path());
  MakeRelative(change.value, folder);
  return Message(change.pointer, "=", change.value.dump());
}

json PatientOf(const fs::path& folder, const NewSuite& suite) {
  json patient = json::object();
  for (const auto& [key, path] : {std::pair{"ct", &suite.ct},
                                  {"labels", &suite.labels},
                                  {"ct_from_reference_file", &suite.transform}}) {
    if (!path->empty())
      patient[key] = *path == "identity" ? path->string() : PathFrom(folder, *path);
  }
  return patient;
}

/// Reads scenario and session as a replay does, and checks that the files of the plan exist.
void RequireReplayable(const NewSuite& suite, RunContext& context) {
  std::vector<scenario::Override> changes;
  for (const auto& [pointer, path] : {std::pair{"/patient/ct", &suite.ct},
                                      {"/patient/labels", &suite.labels},
                                      {"/patient/ct_from_reference_file", &suite.transform}}) {
    if (!path->empty()) changes.push_back({pointer, path->string()});
  }
  for (const std::string& text : suite.changes) changes.push_back(scenario::ParseOverride(text));
  const fs::path file = config::FindConfig(suite.scenario, fs::current_path());
  const scenario::Scenario scenario = scenario::ReadScenario(file, changes);
  context.provenance.AddInput(file);
  for (const fs::path& session : suite.sessions) {
    replay::CheckText(scenario, session, replay::PlanDetail::kStages, context);
  }
}

}  // namespace

std::string WriteNewSuite(const fs::path& output, const NewSuite& suite, RunContext& context) {
  ACUS_REQUIRE(!fs::exists(output / "expected"), output.string(),
               ": has expectations, which a new suite would lose; choose another folder, or move ",
               (output / "expected").string(), " away");
  AtomicFolder files(output, context.overwrite);
  RequireReplayable(suite, context);
  const fs::path folder = fs::absolute(output).lexically_normal();
  comparison::ReadTolerances(config::FindConfig(suite.tolerances, fs::current_path()));
  json set = json::array();
  for (const std::string& change : suite.changes) set.push_back(ChangeFrom(folder, change));
  const json patient = PatientOf(folder, suite);
  std::set<std::string> names;
  json cases = json::array();
  for (const fs::path& session : suite.sessions) {
    json entry = {{"name", NameOfCase(session, names)},
                  {"scenario", ConfigFrom(folder, suite.scenario)},
                  {"session", PathFrom(folder, session)}};
    if (!set.empty()) entry["set"] = set;
    if (!patient.empty()) entry["patient"] = patient;
    cases.push_back(std::move(entry));
  }
  json document = {{"format", "acus-regression/1"},
                   {"tolerances", ConfigFrom(folder, suite.tolerances)},
                   {"cases", cases}};
  if (!suite.description.empty()) document["description"] = suite.description;
  config::WriteJson(files.path() / "suite.json", document);
  config::WriteJson(files.path() / "provenance.json", context.provenance.ToJson());
  files.Commit();
  std::string text = Message((output / "suite.json").string(), ": ",
                             Counted(static_cast<std::int64_t>(names.size()), "case"), ":");
  for (const std::string& name : names) text += " " + name;
  return text + "\nNothing is expected yet. Next: acus-regression run " + output.string() +
         " -o RESULT, look at RESULT/regression.html, acus-regression accept " + output.string() +
         " RESULT\n";
}

std::function<std::string(RunContext& context)> AddNewSuiteOptions(CLI::App& command) {
  struct Options {
    NewSuite suite;
    fs::path output;
  };
  const auto options = std::make_shared<Options>();
  NewSuite& suite = options->suite;
  command
      .add_option("scenario", suite.scenario,
                  "Scenario (acus-scenario JSON) that the sessions are replayed through: a file,\n"
                  "or a preset")
      ->required();
  command.add_option("sessions", suite.sessions, "Recorded sessions, as acus-replay takes them")
      ->required()
      ->check(CLI::ExistingPath);
  command.add_option("--ct", suite.ct, "The patient's CT, in place of the scenario's")
      ->check(CLI::ExistingPath);
  command
      .add_option("--labels", suite.labels, "The patient's label map, in place of the scenario's")
      ->check(CLI::ExistingFile);
  command
      .add_option("--transform", suite.transform,
                  "ct_from_reference.tfm of acus-register in place of the scenario's, or identity")
      ->check(CLI::ExistingFile | CLI::IsMember({"identity"}));
  command.add_option("--set", suite.changes,
                     "Change one value of the scenario in all cases: /json/pointer=value");
  command
      .add_option("--tolerances", suite.tolerances,
                  "How far a run may differ (acus-tolerances JSON): a file, or a preset")
      ->capture_default_str();
  command.add_option("--description", suite.description, "What the suite guards");
  command.add_option("-o,--output", options->output, "Folder of the suite to make")->required();
  return [options](RunContext& context) {
    return WriteNewSuite(options->output, options->suite, context);
  };
}

}  // namespace acus::regression
