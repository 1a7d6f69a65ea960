// On what machine numbers were measured.
#pragma once

#include <string>

namespace acus {

/// The processor as /proc/cpuinfo names it, and how many threads it runs: "Intel(R) Xeon(R) ...,
/// 2 threads".
std::string MachineName();

}  // namespace acus
