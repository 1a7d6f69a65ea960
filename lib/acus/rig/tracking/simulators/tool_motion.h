// What tracked tools do over time: a recording or a script.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acus/data/session/session.h"
#include "acus/rig/tracking/pose_server.h"

namespace acus::simulators {

/// Names that the poses go by on the network, as PLUS names transforms.
struct ToolNames {
  std::string needle = "NeedleToReference";
  std::string probe = "ProbeToReference";
};

/// Times are from the beginning of the motion, ns. Const: the same time gives the same poses.
class ToolMotion {
 public:
  virtual ~ToolMotion() = default;
  /// End of the motion; nothing if it continues for ever.
  virtual std::optional<std::int64_t> end_ns() const = 0;
  /// The first instant after `time_ns` at which a tool is measured; nothing after the last. Begin
  /// with -1.
  virtual std::optional<std::int64_t> Next(std::int64_t time_ns) const = 0;
  /// The tools at such an instant; those without a measurement then are omitted.
  virtual std::vector<tracking::NamedPose> At(std::int64_t time_ns) const = 0;
};

/// A recording as it was: each reading at its time, not seen where it was not seen.
/// @throws InputError if the session has neither needle nor probe.
std::unique_ptr<ToolMotion> RecordedMotion(session::Session session, const ToolNames& names);

/// A recording as a tracker of another rate would have seen it: all tools at each instant,
/// interpolated. @throws InputError as above, or if the rate is not in [0.1, 5000] Hz.
std::unique_ptr<ToolMotion> ResampledMotion(session::Session session, const ToolNames& names,
                                            double rate_hz);

/// Forth and back without end, so that nothing jumps where it begins again.
/// @throws InputError if the motion has no end, or is shorter than 1 ms.
std::unique_ptr<ToolMotion> ForthAndBack(std::unique_ptr<ToolMotion> motion);

}  // namespace acus::simulators
