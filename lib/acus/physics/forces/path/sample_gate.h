// What every force model does with samples that it cannot step on.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/forces/path/needle_sample.h"

namespace acus::forces {

/// The base of a model's state. A plain value.
struct SampleGate {
  bool started = false;
  double time_s = 0.0;             ///< Of the last sample taken in.
  double valid_time_s = 0.0;       ///< Of the last valid one.
  NeedleForce held;                ///< The last force computed from a valid sample.
  std::int64_t num_rejected = 0;   ///< Samples with a value that is not finite or no axis.
  std::int64_t num_time_back = 0;  ///< Samples not later than the one before.

  enum class Verdict {
    kStep,  ///< Valid and later: step, then call Accept().
    kHold,  ///< Time not later, or the needle is lost: Held().
    kZero,  ///< Invalid, or lost before it was ever seen: no force, the state stays.
  };
  Verdict Judge(double sample_time_s, bool valid, const Eigen::Vector3d& tip_in_ct_mm,
                const Eigen::Vector3d& axis_in_ct) noexcept;
  Verdict Judge(const NeedleInput& input) noexcept {
    return Judge(input.time_s, input.valid, input.tip_in_ct_mm, input.axis_in_ct);
  }

  /// The remaining share of the last force: 1 for the table's tracking_loss hold time, then
  /// falling to 0 over its ramp.
  double HeldShare(const ForceSettings& settings) const noexcept;
  /// The last force times that share, without its event.
  NeedleForce Held(const ForceSettings& settings) const noexcept;
  /// The answer to a sample that is not stepped on. @pre `verdict` is not kStep.
  NeedleForce ForceInstead(Verdict verdict, const ForceSettings& settings) const noexcept {
    return verdict == Verdict::kHold ? Held(settings) : NeedleForce{};
  }

  void Accept(double sample_time_s, const NeedleForce& force) noexcept {
    started = true;
    valid_time_s = sample_time_s;
    held = force;
  }
};

}  // namespace acus::forces
