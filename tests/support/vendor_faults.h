// Faults of haptic devices, and what must become of each: for the test that makes them, and for
// docs/concepts/haptic_devices.md, which has this table.
#pragma once

#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "acus/rig/haptics/devices_file.h"
#include "acus/rig/haptics/force_guard.h"

namespace acus::testing_support {

enum class Outcome {
  kRefused,      ///< Opening or starting it says why.
  kRunsOn,       ///< Zero force if `act` is a fault, then ramp-in.
  kReopened,     ///< Zero force, opened again, ramp-in.
  kKeepsTrying,  ///< Zero force; is opened again and again.
  kEnds,         ///< Zero force, halted for good.
  kNoForce,      ///< Runs, but no force ever comes.
};

struct VendorFault {
  haptics::DriverKind driver;
  const char* name;     ///< Of the test.
  const char* what;     ///< In plain words.
  const char* variant;  ///< Of the library.
  const char* faults;
  Outcome outcome;
  const char* says = "";  ///< Part of the message.
  std::optional<haptics::GuardAct> act = std::nullopt;
  bool needs_button = false;  ///< A dead-man button is asked for.
};

inline void PrintTo(const VendorFault& fault, std::ostream* out) {
  *out << fault.what << " (" << fault.variant << ": " << fault.faults << ")";
}

const std::vector<VendorFault>& VendorFaults();

/// Rows of the table, markdown.
std::string VendorFaultTable();

}  // namespace acus::testing_support
