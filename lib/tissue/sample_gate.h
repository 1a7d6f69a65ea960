// What a level does with samples that it cannot step on, the same as forces::NeedleForceModel.
#pragma once

#include <cstdint>

#include "forces/force_table.h"
#include "forces/needle_force.h"
#include "tissue/tool_sample.h"

namespace acus::tissue {

/// Part of a level's state. A plain value.
struct SampleGate {
  bool started = false;
  double time_s = 0.0;             ///< Of the last sample taken in.
  double valid_time_s = 0.0;       ///< Of the last valid one.
  forces::NeedleForce held;        ///< The last force computed from a valid sample.
  std::int64_t num_rejected = 0;   ///< Samples with a value that is not finite or no axis.
  std::int64_t num_time_back = 0;  ///< Samples not later than the one before.

  enum class Verdict {
    kStep,  ///< Valid and later: step, then call Accept().
    kHold,  ///< Time not later, or the needle is lost: Held().
    kZero,  ///< Rubbish: no force, the state stays.
  };
  Verdict Judge(const ToolSample& sample) noexcept;

  /// The last force, which falls to zero after the table's tracking_loss times.
  forces::NeedleForce Held(const forces::ForceSettings& settings) const noexcept;

  void Accept(const ToolSample& sample, const forces::NeedleForce& force) noexcept;
};

/// Of two events of one step, the one that is told (the order is that of forces::NeedleEvent).
forces::NeedleEvent FirstOf(forces::NeedleEvent a, forces::NeedleEvent b) noexcept;

/// All parts times `share`; the event stays.
void Scale(forces::NeedleForce& force, double share) noexcept;

/// Scales the force down so that its magnitude is at most `largest_n`.
void LimitTo(forces::NeedleForce& force, double largest_n) noexcept;

}  // namespace acus::tissue
