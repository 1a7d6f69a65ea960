// Metrics of an exercise about the hands: phases, smoothness, and motion of the probe.
#pragma once

#include <optional>
#include <vector>

#include "acus/run/training/session_metrics.h"

namespace acus::training {

/// The phases of a session with one needle, as session times in ns.
struct InsertionPhases {
  std::int64_t begin_ns = 0;    ///< First sample of any tool.
  std::int64_t aim_ns = 0;      ///< From here to the contact, the tip is within kNearEntryMm.
  std::int64_t contact_ns = 0;  ///< First sample of the tip in tissue.
  std::int64_t deepest_ns = 0;  ///< The tip first is within kAtDepthMm of the end of the last pass.
  std::int64_t end_ns = 0;      ///< The tip leaves that region, or the session ends.
};

inline constexpr double kNearEntryMm = 30.0;
inline constexpr double kAtDepthMm = 1.0;

/// Nothing without a pass in tissue.
std::optional<InsertionPhases> FindPhases(const session::Session& session,
                                          const InsideTissue& inside,
                                          const PassOptions& options = {});

/// "time of search", "... of aiming", "... of advance", "... at depth" (between the times of
/// InsertionPhases); "needle smoothness, spectral arc length" and "..., log dimensionless jerk" of
/// the advance, from the tip's speed at 100 Hz; with a probe, "probe wander during the advance":
/// RMS distance from its mean position. Metrics that cannot be computed are not in the list.
std::vector<Metric> HandlingMetricsOf(const session::Session& session, const Anatomy& anatomy,
                                      const PassOptions& options = {});

}  // namespace acus::training
