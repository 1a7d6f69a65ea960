// A library that leaves a mark when it is loaded: the file `code_ran` in the working directory, or
// the one that ACUS_MARK names.
#include <cstdio>
#include <cstdlib>

namespace {

[[gnu::constructor]] void LeaveMark() {
  const char* place = std::getenv("ACUS_MARK");
  if (std::FILE* file = std::fopen(place != nullptr ? place : "code_ran", "w")) {
    std::fputs("loaded\n", file);
    std::fclose(file);
  }
}

}  // namespace
