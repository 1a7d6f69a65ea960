// Which build of Acus this is. Defined in a source that every build makes (lib/version.cmake).
#pragma once

#include <string>

namespace acus {

/// The number of the release: "0.1.0".
std::string VersionNumber();

/// The build, as `--version` prints it: the number and, if it was built in a repository, the
/// commit: "0.1.0 (034f33f)"; "-dirty" if files of the repository had changed.
std::string Version();

}  // namespace acus
