// The machine that a page's numbers are from, as pages name it.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace acus::benchmarks {

/// cpu, cores, memory_gb, system, virtual ("a virtual machine" or "a machine of its own"), compiler
/// and acus (its version). No names of hosts, users or places.
nlohmann::json MachineFacts();

}  // namespace acus::benchmarks
