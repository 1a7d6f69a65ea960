#include "acus/base/core/machine.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <limits>
#include <optional>
#include <sys/resource.h>
#include <thread>

#include "acus/base/core/error.h"
#include "acus/base/core/words.h"

namespace acus {
namespace {

/// What stands behind the separator in the first line that begins with `key`; without quotes.
std::string ValueOf(const char* file, std::string_view key, char separator,
                    const char* if_missing) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const std::size_t end = line.find(separator);
    if (!line.starts_with(key) || end == line.npos) continue;
    std::string value(Trimmed(std::string_view(line).substr(end + 1)));
    std::erase(value, '"');
    if (!value.empty()) return value;
  }
  return if_missing;
}

/// A number at the beginning of a text; nothing if there is none ("max").
std::optional<double> NumberIn(const std::string& text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return {};
  return number;
}

/// A line of a file such as /proc/meminfo, "MemTotal: 8123456 kB", in bytes.
std::optional<double> BytesOf(const char* file, std::string_view key) {
  const auto kib = NumberIn(ValueOf(file, key, ':', ""));
  if (!kib) return {};
  return *kib * 1024.0;
}

/// The first line of a file.
std::string FirstLine(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

/// What the control group (version 2) of this process leaves, and those above it.
double ControlGroupBytes() {
  double least = std::numeric_limits<double>::infinity();
  std::string group = ValueOf("/proc/self/cgroup", "0:", ':', "");  // "0::/a/b"
  group.erase(0, group.find('/'));
  for (;;) {
    const std::string folder = "/sys/fs/cgroup" + group;
    const auto most = NumberIn(FirstLine(folder + "/memory.max"));
    const auto now = NumberIn(FirstLine(folder + "/memory.current"));
    if (most && now) least = std::min(least, std::max(0.0, *most - *now));
    const std::size_t slash = group.rfind('/');
    if (slash == group.npos) return least;
    group.erase(slash);
  }
}

}  // namespace

Machine ThisMachine() {
  Machine out;
  out.processor = ValueOf("/proc/cpuinfo", "model name", ':', out.processor.c_str());
  out.threads = static_cast<int>(std::thread::hardware_concurrency());
  out.memory_gb = BytesOf("/proc/meminfo", "MemTotal").value_or(0.0) / 1e9;
  const std::string flags = " " + ValueOf("/proc/cpuinfo", "flags", ':', "") + " ";
  out.is_virtual = flags.find(" hypervisor ") != flags.npos;
  out.system = ValueOf("/etc/os-release", "PRETTY_NAME", '=', out.system.c_str());
  return out;
}

double AvailableMemoryBytes() {
  double least = ControlGroupBytes();
  if (const auto free = BytesOf("/proc/meminfo", "MemAvailable")) least = std::min(least, *free);
  rlimit limit{};
  const auto used = BytesOf("/proc/self/status", "VmSize");
  if (::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && used) {
    least = std::min(least, std::max(0.0, static_cast<double>(limit.rlim_cur) - *used));
  }
  return least;
}

std::string MachineName() {
  const Machine machine = ThisMachine();
  return Message(machine.processor, ", ", machine.threads, " threads");
}

}  // namespace acus
