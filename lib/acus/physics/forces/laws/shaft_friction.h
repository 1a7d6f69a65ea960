// Friction along a shaft whose tissues relax, and hold it by how fast it slides and how long it
// rested. Equations: docs/models/needle_forces.md, "Time".
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/forces/laws/friction_pace.h"
#include "acus/physics/forces/path/needle_path.h"

namespace acus::forces {

/// What tissues hold a tip with that is withdrawn. They share the last 5 mm of the needle by
/// length, so that the force has no step where they meet, and none where the tip leaves the skin.
/// Const.
class TipGrip {
 public:
  explicit TipGrip(const ForceTable& table);

  /// @param share_of  of a tissue's full grip, by label.  @param depth_mm  of the tip.
  template <typename ShareOf>
  double SumN(const NeedlePath& path, double depth_mm, const ShareOf& share_of) const noexcept {
    if (!grips_) return 0.0;
    const auto grip = [&](const NeedlePath::Segment& segment) {
      return n_per_mm_[segment.tissue] * share_of(segment.tissue);
    };
    return path.SumN(depth_mm, grip) - path.SumN(std::max(0.0, depth_mm - kTipMm), grip);
  }

 private:
  static constexpr double kTipMm = 5.0;
  std::array<double, 256> n_per_mm_{};
  bool grips_ = false;
};

/// A plain value.
struct ShaftFrictionState : FrictionPace {
  /// Strain of the elastic and the relaxing bristles, by law; 1 slides steadily at the reference
  /// speed.
  std::array<std::array<double, ForceRelaxation::kMostTerms + 1>, ForceTable::kMostTimes> strain{};
};

/// Const after construction. Bristles of each of the table's times side by side,
///   ds/dt = v / b - s / tau, held in [-g, g] by sliding (a strain beyond a g that has fallen is
///   taken off over a travel of b),
///   g = 1 + rate * RateLog(v) + dwell * DwellLog(age),  d(age)/dt = 1 - |v| age / slip.
/// Never give more energy than they took, for any g > 0 (docs/models/needle_forces.md).
class ShaftFriction {
 public:
  explicit ShaftFriction(const ForceTable& table);

  /// Exact for constant speed where g is constant; else g is that of the middle of pieces of 5 ms
  /// and a quarter of the slip, 64 at most. Travel back and forth by up to 5 um is neither speed
  /// nor slip. @param travel_mm  + into the tissue.  @param dt_s  > 0.
  void Slide(ShaftFrictionState& state, double travel_mm, double dt_s) const noexcept;

  /// Force on a shaft buried from 0 to `depth_mm`, with its tip, + pushes it out.
  double ForceN(const ShaftFrictionState& state, const NeedlePath& path,
                double depth_mm) const noexcept;

 private:
  struct Law {
    TissueTime time;
    double steady = 1.0;  ///< Sum of the strains that slide steadily at the reference speed.
  };

  FrictionTime settings_;
  TipGrip grip_;
  double buildup_mm_;
  std::array<Law, ForceTable::kMostTimes> law_{};
  int num_laws_ = 0;
  std::array<std::uint8_t, 256> law_of_{};
  bool limits_vary_ = false;
};

}  // namespace acus::forces
