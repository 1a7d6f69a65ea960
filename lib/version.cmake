# Writes the source that says which build this is; run by every build, as
#   cmake -D SOURCE=folder -D VERSION=number -D OUTPUT=file -P lib/version.cmake
# The file is rewritten only when its text changes, so that a build without a new commit compiles
# nothing. Without git, or outside a repository, the build is named by its number alone.
set(build "${VERSION}")
find_program(GIT git)
# A repository around an unpacked archive says nothing about the archive.
if(GIT AND EXISTS "${SOURCE}/.git")
  execute_process(COMMAND "${GIT}" --no-optional-locks -C "${SOURCE}" describe --tags --always --dirty
                  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE
                  RESULT_VARIABLE failed ERROR_QUIET)
  if(NOT failed AND commit MATCHES "^[-A-Za-z0-9._/+]+$")
    set(build "${VERSION} (${commit})")
  endif()
endif()
file(CONFIGURE OUTPUT "${OUTPUT}" @ONLY CONTENT [[
#include "acus/base/core/version.h"

namespace acus {
std::string VersionNumber() { return "@VERSION@"; }
std::string Version() { return "@build@"; }
}  // namespace acus
]])
