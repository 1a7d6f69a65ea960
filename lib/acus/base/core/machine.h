// On what machine numbers were measured. No names of hosts, users or places.
#pragma once

#include <string>

namespace acus {

struct Machine {
  std::string processor = "unknown processor";  ///< As /proc/cpuinfo names it.
  int threads = 0;                              ///< That it runs at a time; 0: unknown.
  double memory_gb = 0.0;                       ///< 10^9 bytes; 0: unknown.
  bool is_virtual = false;                      ///< It runs under a hypervisor.
  std::string system = "unknown system";        ///< As /etc/os-release names it.
};

Machine ThisMachine();

/// Memory in bytes that this process can still take: by the system, its control group and its limit
/// of address space. Infinite if none of them is known.
double AvailableMemoryBytes();

/// Processor and threads: "Intel(R) Xeon(R) ..., 2 threads".
std::string MachineName();

}  // namespace acus
