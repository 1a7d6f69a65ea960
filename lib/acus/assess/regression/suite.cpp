#include "acus/assess/regression/suite.h"

#include <algorithm>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::regression {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

Case CaseOf(const json& entry, const fs::path& folder, const std::string& suite_tolerances) {
  Case c;
  c.name = entry.at("name");
  c.scenario = config::FindConfig(entry.at("scenario").get<std::string>(), folder);
  c.session = folder / entry.at("session").get<std::string>();
  for (const auto& [key, path] : entry.at("patient").items()) {
    const std::string name = path.get<std::string>();
    c.changes.push_back({"/patient/" + key, name == "identity" ? name : (folder / name).string()});
  }
  for (const json& change : entry.at("set")) {
    c.changes.push_back(scenario::ForAnyFolder(scenario::ParseOverride(change), folder));
  }
  const std::string own = entry.at("tolerances");
  c.tolerances = config::FindConfig(own.empty() ? suite_tolerances : own, folder);
  return c;
}

}  // namespace

Suite ReadSuite(const fs::path& file_or_folder) {
  const fs::path file =
      fs::is_directory(file_or_folder) ? file_or_folder / "suite.json" : file_or_folder;
  const json document = config::ReadConfig(file, "acus-regression");
  Suite suite;
  suite.folder = fs::absolute(file).parent_path();
  suite.description = document.at("description");
  suite.time_percent = document.at("time_percent");
  suite.time_min_s = document.at("time_min_s");
  std::set<std::string> names;
  for (const json& entry : document.at("cases")) {
    suite.cases.push_back(CaseOf(entry, suite.folder, document.at("tolerances")));
    const Case& c = suite.cases.back();
    ACUS_REQUIRE(names.insert(c.name).second, file.string(), ": /cases: two are named \"", c.name,
                 "\"; each needs a name of its own");
    ACUS_REQUIRE(fs::exists(c.session), file.string(), ": /cases: ", c.name, ": ",
                 c.session.string(), ": no such session");
  }
  return suite;
}

Suite With(Suite suite, const std::vector<std::string>& changes) {
  for (const std::string& text : changes) {
    const scenario::Override change =
        scenario::ForAnyFolder(scenario::ParseOverride(text), fs::current_path());
    for (Case& c : suite.cases) c.changes.push_back(change);
    suite.set.push_back(text);
  }
  return suite;
}

Suite Only(Suite suite, const std::vector<std::string>& names) {
  if (names.empty()) return suite;
  std::string known;
  for (const Case& c : suite.cases) known += (known.empty() ? "" : ", ") + c.name;
  for (const std::string& name : names) {
    ACUS_REQUIRE(std::ranges::find(suite.cases, name, &Case::name) != suite.cases.end(),
                 "there is no case \"", name, "\"; the suite has: ", known);
  }
  std::erase_if(suite.cases, [&names](const Case& c) {
    return std::ranges::find(names, c.name) == names.end();
  });
  return suite;
}

}  // namespace acus::regression
