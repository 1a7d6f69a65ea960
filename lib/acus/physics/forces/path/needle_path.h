// The channel that a needle has cut: a straight line from the skin and the tissues along it.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>

#include "acus/data/volume/volume.h"

namespace acus::forces {

/// Depths are along the line since the skin, in mm. Fixed size, so that it can be copied in a step.
struct NeedlePath {
  static constexpr int kMaxSegments = 64;

  /// From the previous segment's end (or 0) to `end_mm`, in one tissue.
  struct Segment {
    double end_mm = 0.0;
    volume::Label tissue = 0;
    double friction_n_per_mm = 0.0;    ///< During insertion.
    double withdrawal_n_per_mm = 0.0;  ///< During withdrawal.
  };

  Eigen::Vector3d entry_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_in_ct = Eigen::Vector3d::UnitZ();  ///< Unit length, into the body.
  std::array<Segment, kMaxSegments> segment{};
  int num_segments = 0;

  double DepthMm(const Eigen::Vector3d& point_in_ct_mm) const noexcept;
  /// From the line to the point, perpendicular to the line.
  Eigen::Vector3d DeviationMm(const Eigen::Vector3d& point_in_ct_mm) const noexcept;

  double EndMm() const noexcept;
  /// Tissue of the last segment; 0 (outside) if there is none.
  volume::Label LastTissue() const noexcept;

  /// Tissue of the segment that this depth is in; of the first before it, of the last behind it.
  volume::Label TissueAt(double depth_mm) const noexcept;

  /// Moves the end of the last segment. @pre there is one.
  void ExtendTo(double end_mm) noexcept;
  /// Starts a segment at the present end. With all kMaxSegments in use, the two shallowest become
  /// one with their mean friction, so that total friction is kept.
  void Append(volume::Label tissue, double friction_n_per_mm, double withdrawal_n_per_mm) noexcept;
  /// Forgets everything deeper.
  void CutOffAt(double end_mm) noexcept;

  /// Full sliding friction of a shaft buried from 0 to `depth_mm` that is pushed in, N.
  double FrictionN(double depth_mm) const noexcept;
  /// The same while it is withdrawn.
  double WithdrawalFrictionN(double depth_mm) const noexcept;

  /// Sum of what `per_mm` gives for a segment, N/mm, over a shaft buried from 0 to `depth_mm`, N.
  template <typename PerMm>
  double SumN(double depth_mm, const PerMm& per_mm) const noexcept {
    double total_n = 0.0;
    double begin_mm = 0.0;
    for (int i = 0; i < num_segments && begin_mm < depth_mm; ++i) {
      const bool last = i + 1 == num_segments;  // The last tissue continues as far as is asked.
      const double end_mm = last ? depth_mm : std::min(segment[i].end_mm, depth_mm);
      total_n += per_mm(segment[i]) * (end_mm - begin_mm);
      begin_mm = segment[i].end_mm;
    }
    return total_n;
  }
};

}  // namespace acus::forces
