#include "benchmarks/machine.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "acus/base/core/machine.h"
#include "acus/base/core/provenance.h"

namespace acus::benchmarks {
namespace {

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
  const Machine machine = ThisMachine();
  return {{"cpu", machine.processor},
          {"cores", machine.threads},
          {"memory_gb", std::lround(machine.memory_gb)},
          {"system", machine.system},
          {"virtual", machine.is_virtual ? "a virtual machine" : "a machine of its own"},
          {"compiler", Compiler()},
          {"acus", Version()}};
}

}  // namespace acus::benchmarks
