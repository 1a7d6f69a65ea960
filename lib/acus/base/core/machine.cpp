#include "acus/base/core/machine.h"

#include <charconv>
#include <fstream>
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

double MemoryGb() {
  const std::string text = ValueOf("/proc/meminfo", "MemTotal", ':', "0");  // "8123456 kB"
  double kib = 0.0;
  std::from_chars(text.data(), text.data() + text.size(), kib);
  return kib * 1024.0 / 1e9;
}

}  // namespace

Machine ThisMachine() {
  Machine out;
  out.processor = ValueOf("/proc/cpuinfo", "model name", ':', out.processor.c_str());
  out.threads = static_cast<int>(std::thread::hardware_concurrency());
  out.memory_gb = MemoryGb();
  const std::string flags = " " + ValueOf("/proc/cpuinfo", "flags", ':', "") + " ";
  out.is_virtual = flags.find(" hypervisor ") != flags.npos;
  out.system = ValueOf("/etc/os-release", "PRETTY_NAME", '=', out.system.c_str());
  return out;
}

std::string MachineName() {
  const Machine machine = ThisMachine();
  return Message(machine.processor, ", ", machine.threads, " threads");
}

}  // namespace acus
