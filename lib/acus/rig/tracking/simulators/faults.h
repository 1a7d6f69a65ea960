// What goes wrong with a tracker, on purpose.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace acus::simulators {

enum class FaultKind {
  kDrop,     ///< The links are closed and none is taken until it is over.
  kFreeze,   ///< Nothing is sent; the links stay.
  kOcclude,  ///< The tools are not seen.
  kNan,      ///< Poses of numbers that are none.
  kJump,     ///< Poses 50 mm aside (along x of the reference).
  kGarbage,  ///< Random bytes between the messages.
};

struct Fault {
  FaultKind kind = FaultKind::kDrop;
  std::int64_t begin_ns = 0;  ///< From the start of playing.
  std::int64_t end_ns = 0;
};

inline constexpr double kJumpMm = 50.0;

/// "occlude@5:2": from 5 s, for 2 s; "drop@12": for 1 s.
/// @throws InputError naming what is allowed.
Fault ParseFault(std::string_view text);

/// What is wrong with such a text; empty if nothing is. For checks of command lines.
std::string FaultProblem(const std::string& text);

/// Whether a fault of the kind is on.
bool IsOn(const std::vector<Fault>& faults, FaultKind kind, std::int64_t time_ns);

}  // namespace acus::simulators
