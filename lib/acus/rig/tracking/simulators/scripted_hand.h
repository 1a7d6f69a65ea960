// A hand that inserts a needle again and again beside a probe that sweeps.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>

#include "acus/rig/tracking/simulators/tool_motion.h"

namespace acus::simulators {

/// Where and how. Points in the reference frame, mm.
struct HandScript {
  Eigen::Vector3d entry_mm = Eigen::Vector3d::Zero();  ///< On the skin.
  Eigen::Vector3d target_mm = {0.0, 0.0, -60.0};       ///< Where the needle is led to.
  double hover_mm = 40.0;        ///< Before the skin, where it begins and ends.
  double insertion_mm_s = 10.0;  ///< Mean speed of the tip.
  double hold_s = 2.0;           ///< At the target, and again before it begins again.
  double tremor_mm = 0.1;        ///< RMS of each axis, 7 to 12 Hz.
  /// The probe stands beside the entry, its beam along the needle's way, and sweeps about there.
  double probe_aside_mm = 25.0;
  double sweep_mm = 10.0;
  double sweep_deg = 5.0;
  double rate_hz = 100.0;
};

/// Approach, insertion, hold, withdrawal, each with the smoothest speed (least jerk: Flash & Hogan,
/// J. Neurosci. 5(7), 1985), for ever. Tremor is a sum of sines, so that poses are smooth at any
/// rate; its frequencies and phases come from the seed.
/// @throws InputError if entry and target are less than 1 mm apart, or a number is out of range.
std::unique_ptr<ToolMotion> ScriptedHand(const HandScript& script, const ToolNames& names,
                                         std::uint64_t seed);

}  // namespace acus::simulators
