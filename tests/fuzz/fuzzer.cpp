// The driver for libFuzzer: the reader that ACUS_READER names, on one input after the other.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <string>
#include <unistd.h>

#include "fuzz/readers.h"

namespace {

const acus::fuzz::Reader* reader = nullptr;
std::filesystem::path file;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  const char* name = std::getenv("ACUS_READER");
  for (const auto& known : acus::fuzz::Readers()) {
    if (name != nullptr && known.name == name) reader = &known;
  }
  if (reader == nullptr) {
    std::fprintf(stderr, "ACUS_READER must name a reader:");
    for (const auto& known : acus::fuzz::Readers()) {
      std::fprintf(stderr, " %.*s", static_cast<int>(known.name.size()), known.name.data());
    }
    std::fprintf(stderr, "\n");
    std::exit(2);
  }
  // In memory: a million files on a disk would take hours.
  const std::filesystem::path folder = "/dev/shm/acus-fuzz-" + std::to_string(::getpid());
  std::filesystem::create_directory(folder);
  file = folder / ("input" + std::string(reader->extension));
  std::atexit([] { std::filesystem::remove_all(file.parent_path()); });
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const int handle = ::open(file.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0600);
  if (handle < 0 || ::write(handle, data, size) != static_cast<ssize_t>(size)) std::abort();
  ::close(handle);
  acus::fuzz::ReadOrRefuse(*reader, file);
  return 0;
}
