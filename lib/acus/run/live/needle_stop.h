// The obstacles that stop a needle: bone at its tip, skin at its hub. A hand yields to both.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "acus/physics/forces/laws/tissue_lookup.h"

namespace acus::live {

enum class StopKind : std::uint8_t { kNone, kBone, kHub };

/// Holds the needle of a virtual hand, which no motor holds. Deterministic; At() takes no lock,
/// allocates nothing and does not throw.
class NeedleStop {
 public:
  /// The tip enters bone by this much: the bone's force grows with it.
  static constexpr double kIntoBoneMm = 1.0;

  struct Held {
    StopKind by = StopKind::kNone;
    double beyond_mm = 0.0;  ///< The needle is to be withdrawn by this along its axis.
  };

  /// @param tissue  Its referenced data must outlive this. @param length_mm  From tip to hub.
  NeedleStop(const forces::TissueLookup& tissue, double length_mm);

  /// @param tip_mm, axis  The needle in the hand, in the CT at rest; the axis is the direction of
  ///     insertion, of unit length.
  Held At(const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& axis) noexcept;

  /// The tracker does not see the needle: its next pose may be elsewhere.
  void Forget() noexcept { last_tip_mm_.reset(); }

 private:
  double StepMm() const noexcept;
  /// The first point on the last `way_mm` along the axis up to `end_mm`, mm before the end.
  template <typename IsThere>
  std::optional<double> FirstMm(const Eigen::Vector3d& end_mm, const Eigen::Vector3d& axis,
                                double way_mm, const IsThere& is_there) const noexcept;

  forces::TissueLookup tissue_;
  double length_mm_;
  volume::Label bone_;
  std::optional<Eigen::Vector3d> last_tip_mm_;  ///< The tip of the held needle.
};

}  // namespace acus::live
