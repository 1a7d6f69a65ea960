#include "acus/base/core/machine.h"

#include <fstream>
#include <thread>

#include "acus/base/core/error.h"

namespace acus {

std::string MachineName() {
  std::ifstream file("/proc/cpuinfo");
  std::string name = "unknown processor";
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(": ");
    if (colon != line.npos) name = line.substr(colon + 2);
    break;
  }
  return Message(name, ", ", std::thread::hardware_concurrency(), " threads");
}

}  // namespace acus
