#include "benchmarks/machine.h"

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>

#include "acus/base/core/provenance.h"
#include "acus/base/core/words.h"

namespace acus::benchmarks {
namespace {

/// What stands behind `key` and `separator` in the first line that begins with it.
std::string LineOf(const char* file, const std::string& key, char separator) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(key)) continue;
    std::string value(Trimmed(line.substr(line.find(separator) + 1)));
    std::erase(value, '"');
    return value;
  }
  return "unknown";
}

std::string Compiler() {
#if defined(__clang__)
  return "Clang " + std::to_string(__clang_major__) + "." + std::to_string(__clang_minor__);
#elif defined(__GNUC__)
  return "GCC " + std::to_string(__GNUC__) + "." + std::to_string(__GNUC_MINOR__);
#else
  return "unknown";
#endif
}

}  // namespace

nlohmann::json MachineFacts() {
  double memory_kb = 0.0;
  std::istringstream(LineOf("/proc/meminfo", "MemTotal", ':')) >> memory_kb;
  const std::string flags = " " + LineOf("/proc/cpuinfo", "flags", ':') + " ";
  const bool is_virtual = flags.find(" hypervisor ") != flags.npos;
  return {{"cpu", LineOf("/proc/cpuinfo", "model name", ':')},
          {"cores", std::thread::hardware_concurrency()},
          {"memory_gb", std::lround(memory_kb / 1e6)},
          {"system", LineOf("/etc/os-release", "PRETTY_NAME", '=')},
          {"virtual", is_virtual ? "a virtual machine" : "a machine of its own"},
          {"compiler", Compiler()},
          {"acus", Version()}};
}

}  // namespace acus::benchmarks
