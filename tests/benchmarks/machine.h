// The machine that a page's numbers are from.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace acus::benchmarks {

/// cpu, cores, memory_gb, system, virtual ("a virtual machine" or "a machine of its own"), compiler
/// and acus (its version); "unknown" for what the system does not tell. No names of hosts, users or
/// places.
nlohmann::json MachineFacts();

}  // namespace acus::benchmarks
