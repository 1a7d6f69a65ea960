// Detects a needle that is moved back and forth, to find it in the image.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace acus::training {

/// Counts turns of the tip along each axis of the reference frame: a turn is where it has come back
/// by kAmplitudeMm from its farthest position. Tremor is smaller, an advance does not turn.
class JiggleMeter {
 public:
  static constexpr double kAmplitudeMm = 1.0;
  static constexpr int kTurns = 3;                          ///< Along one axis,
  static constexpr std::int64_t kWithinNs = 3'000'000'000;  ///< in this time.

  void Add(std::int64_t time_ns, const Eigen::Vector3d& tip_mm);
  /// State at the last sample.
  bool jiggled() const { return jiggled_; }

 private:
  struct Axis {
    bool begun = false;
    double low_mm = 0.0, high_mm = 0.0;  ///< Range since the last turn.
    int direction = 0;                   ///< Sign of the last stroke; 0: none yet.
    std::array<std::int64_t, kTurns> turn_ns{};
    int turns = 0;

    void Add(std::int64_t time_ns, double place_mm);
    bool TurnedWithin(std::int64_t time_ns) const;
  };

  std::array<Axis, 3> axes_;
  bool jiggled_ = false;
};

}  // namespace acus::training
