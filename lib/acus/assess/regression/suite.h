// A suite of recorded sessions whose results are expected not to change.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/scene/scenario/scenario.h"

namespace acus::regression {

/// One replay. Paths are absolute.
struct Case {
  std::string name;
  std::filesystem::path scenario;
  std::filesystem::path session;
  std::vector<scenario::Override> changes;  ///< Changes of the patient, then those of /set.
  std::filesystem::path tolerances;
};

struct Suite {
  std::filesystem::path folder;  ///< Expectations are in its folder expected/<name of the case>.
  std::string description;
  double time_percent = 0.0;
  double time_min_s = 0.0;
  std::vector<std::string> set;  ///< Changes for this run alone, in the user's text.
  std::vector<Case> cases;

  std::filesystem::path ExpectedOf(const Case& c) const { return folder / "expected" / c.name; }
};

/// Reads an acus-regression file, or suite.json of a folder.
/// @throws InputError listing all problems: keys, two cases of one name, files that do not exist.
Suite ReadSuite(const std::filesystem::path& file_or_folder);

/// Changes every case, after its own changes. The suite's results can then not be accepted.
/// @param changes  "/pointer=value"; paths are relative to the working folder.
/// @throws InputError as ParseOverride.
Suite With(Suite suite, const std::vector<std::string>& changes);

/// Keeps the named cases. @throws InputError with the first unknown name, and all valid ones.
Suite Only(Suite suite, const std::vector<std::string>& names);

}  // namespace acus::regression
