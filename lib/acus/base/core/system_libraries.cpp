#include "acus/base/core/system_libraries.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <elf.h>
#include <fstream>
#include <iterator>
#include <link.h>
#include <optional>
#include <set>

#include "acus/base/core/error.h"

namespace acus {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kCacheMagic = "glibc-ld.so.cache1.1";
constexpr std::size_t kCacheHeaderBytes = 48;  ///< Magic, number of entries, and what we skip.
constexpr std::size_t kCacheEntryBytes = 24;   ///< Flags, name, path, version, hardware.

std::uint32_t NumberAt(std::string_view cache, std::size_t offset) {
  std::uint32_t number = 0;
  std::memcpy(&number, cache.data() + offset, sizeof number);
  return number;
}

/// The text of the cache at `offset`; nothing if it does not end within the cache.
std::optional<std::string_view> TextAt(std::string_view cache, std::size_t offset) {
  const std::size_t end = cache.find('\0', offset);
  if (offset >= cache.size() || end == cache.npos) return {};
  return cache.substr(offset, end - offset);
}

/// What the loader asks of a file before it takes it: made for processors like this one.
std::optional<std::array<int, 2>> MachineOf(const fs::path& file) {
  ElfW(Ehdr) header{};
  std::ifstream in(file, std::ios::binary);
  if (!in.read(reinterpret_cast<char*>(&header), sizeof header)) return {};
  if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) return {};
  return std::array<int, 2>{header.e_ident[EI_CLASS], header.e_machine};
}

bool IsForThisMachine(const fs::path& file) {
  static const auto ours = MachineOf("/proc/self/exe");
  const auto its = MachineOf(file);
  return its && its == ours;
}

/// Where the system's own folders begin, which come after the cache: the last ones, each once.
std::size_t FirstSystemFolder(const std::vector<std::string>& folders) {
  std::size_t first = folders.size();
  for (std::set<std::string> seen; first > 0; --first) {
    const std::string& folder = folders[first - 1];
    const bool is_system = folder.starts_with("/lib") || folder.starts_with("/usr/lib");
    if (!is_system || !seen.insert(folder).second) break;
  }
  return first;
}

}  // namespace

std::vector<std::string> LoaderFolders() {
  std::vector<std::string> folders;
  void* program = dlopen(nullptr, RTLD_LAZY);
  Dl_serinfo size{};
  ACUS_REQUIRE(program != nullptr && dlinfo(program, RTLD_DI_SERINFOSIZE, &size) == 0,
               "the loader does not say where it searches for libraries: ", dlerror());
  // The list is a struct with texts behind it; its size is known only now.
  std::vector<std::max_align_t> memory(size.dls_size / sizeof(std::max_align_t) + 1);
  auto* list = reinterpret_cast<Dl_serinfo*>(memory.data());
  ACUS_REQUIRE(dlinfo(program, RTLD_DI_SERINFOSIZE, list) == 0 &&
                   dlinfo(program, RTLD_DI_SERINFO, list) == 0,
               "the loader does not say where it searches for libraries: ", dlerror());
  for (unsigned i = 0; i < list->dls_cnt; ++i) folders.emplace_back(list->dls_serpath[i].dls_name);
  return folders;
}

void CheckSearch(const std::vector<std::string>& folders) {
  for (const std::string& folder : folders) {
    if (folder.starts_with('/')) continue;
    const char* variable = std::getenv("LD_LIBRARY_PATH");
    throw InputError(
        Message("LD_LIBRARY_PATH is '", variable != nullptr ? variable : "", "': its entry '",
                folder, "' is the working directory or relative to it; allowed with a vendor's ",
                "library: absolute paths only. Take out what is relative or empty (a colon at the "
                "start or the end is an empty entry)"));
  }
}

std::vector<std::string> PathsInCache(std::string_view cache, std::string_view name) {
  std::vector<std::string> paths;
  if (!cache.starts_with(kCacheMagic) || cache.size() < kCacheHeaderBytes) return paths;
  const std::size_t num_entries = NumberAt(cache, kCacheMagic.size());
  if (num_entries > (cache.size() - kCacheHeaderBytes) / kCacheEntryBytes) return paths;
  for (std::size_t i = 0; i < num_entries; ++i) {
    const std::size_t entry = kCacheHeaderBytes + i * kCacheEntryBytes;
    if (TextAt(cache, NumberAt(cache, entry + 4)) != name) continue;
    const auto path = TextAt(cache, NumberAt(cache, entry + 8));
    if (path) paths.emplace_back(*path);
  }
  return paths;
}

fs::path FindSystemLibrary(const std::string& name) {
  const std::vector<std::string> folders = LoaderFolders();
  std::vector<fs::path> candidates(folders.begin(), folders.end());
  for (fs::path& candidate : candidates) candidate /= name;
  std::ifstream in("/etc/ld.so.cache", std::ios::binary);
  const std::string cache{std::istreambuf_iterator<char>(in), {}};
  const std::vector<std::string> cached = PathsInCache(cache, name);
  const auto first_system = static_cast<std::ptrdiff_t>(FirstSystemFolder(folders));
  candidates.insert(candidates.begin() + first_system, cached.begin(), cached.end());
  for (const fs::path& file : candidates) {
    if (IsForThisMachine(file)) return file;
  }
  return {};
}

}  // namespace acus
