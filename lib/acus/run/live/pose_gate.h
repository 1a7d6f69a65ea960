// Judges the reading of a tracked tool before anything is computed from it.
#pragma once

#include <cstdint>

#include "acus/data/transforms/pose.h"

namespace acus::live {

struct PoseGateSettings {
  double jump_mm = 10.0;       ///< Largest change between readings, however close in time ...
  double speed_mm_s = 1000.0;  ///< ... plus this for the time between them, 0.1 s at most.
  double jump_rad = 0.5;       ///< The same for rotations ...
  double speed_rad_s = 20.0;   ///< ... and this.
  double settle_s = 0.3;       ///< A tool that jumped and stays there is accepted after this time.
};

/// Why a pose is rejected.
enum class PoseVerdict : std::uint8_t {
  kGood,
  kNotSeen,    ///< Reported by the device or tracker, or no reading for too long.
  kNotFinite,  ///< Or farther away than a tool can be.
  kJumped,
};

/// One for each tool. Pure: the time comes with the readings. Allocates nothing.
class PoseGate {
 public:
  explicit PoseGate(const PoseGateSettings& settings = {}) noexcept : settings_(settings) {}

  /// Judges a reading. @param seen  False: it counts as not seen.
  PoseVerdict Judge(std::int64_t time_ns, const transforms::Pose& pose, bool seen) noexcept;

  /// The last good pose; the identity before the first.
  const transforms::Pose& last_good() const noexcept { return last_good_; }

 private:
  bool IsNear(const transforms::Pose& before, std::int64_t before_ns, const transforms::Pose& pose,
              std::int64_t time_ns) const noexcept;

  PoseGateSettings settings_;
  bool has_good_ = false;
  transforms::Pose last_good_;
  std::int64_t good_ns_ = 0;
  // The pose after a jump, the time of the jump, and the time of the last reading there.
  bool has_new_place_ = false;
  transforms::Pose new_place_;
  std::int64_t new_since_ns_ = 0;
  std::int64_t new_ns_ = 0;
};

}  // namespace acus::live
