// Attempts, passes and redirections: how often the needle was turned round on its way.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "acus/run/training/motion_metrics.h"

namespace acus::training {

/// One advance of the needle in tissue, from a turning point to the next.
struct NeedlePass {
  std::int64_t begin_ns = 0;  ///< The entry, or where the needle was drawn back to.
  std::int64_t end_ns = 0;    ///< The deepest point.
  int attempt = 0;            ///< Insertions through the skin, from 0.
  double advance_mm = 0.0;    ///< Along the shaft.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();   ///< Of the needle at its deepest point.
  Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero();  ///< Of the tip there; frame of the stream.
  /// It follows another pass of the same attempt, in another direction.
  bool redirected = false;
};

struct PassOptions {
  /// A way forward or back along the shaft counts as such from this length on: shorter ones are
  /// tremor and feeling one's way. > 0.
  double turn_mm = 5.0;
  double redirection_rad = 0.0523598775598299;  ///< Smallest change of direction, 3 degrees. > 0.
  double withdrawal_mm = 5.0;  ///< As MetricOptions::withdrawal_mm: what ends an attempt. >= 0.
};

/// All passes of a needle stream, in order of time. The way along the shaft is the sum of the tip's
/// motions projected on the needle's axis, so that a sideways sweep is not a pass.
/// @param inside  Whether a point, in the stream's frame, lies in tissue.
/// @throws InputError if an option is out of its range.
std::vector<NeedlePass> FindPasses(const session::PoseStream& needle, const InsideTissue& inside,
                                   const PassOptions& options = {});

}  // namespace acus::training
