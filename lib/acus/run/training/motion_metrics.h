// What a training session is judged by: times, paths and the damage that the needle does.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "acus/data/session/session.h"

namespace acus::training {

/// Whether a point, in the session's reference frame (mm), lies in tissue.
using InsideTissue = std::function<bool(const Eigen::Vector3d& point_in_reference_mm)>;

/// Metrics of the motion of one tool's origin (for a needle: its tip). Invalid samples are left
/// out: the motion is taken as straight from the valid sample before to the one after.
struct MotionMetrics {
  double elapsed_time_s = 0.0;  ///< From the first to the last valid sample.
  double path_length_mm = 0.0;
  double mean_speed_mm_per_s = 0.0;  ///< Path over time.
  /// Largest distance covered within MetricOptions::speed_window_s, over that time.
  double max_speed_mm_per_s = 0.0;
};

/// Metrics of a needle in tissue. As Perk Tutor defines them, so that results can be compared: each
/// step counts as in tissue if its end is; damage is summed over steps that begin and end in
/// tissue.
struct TissueMetrics {
  double time_in_tissue_s = 0.0;
  double path_in_tissue_mm = 0.0;
  int num_insertions = 0;  ///< Entries of the tip into tissue, tremor at the surface not counted.
  /// Area that the part of the shaft in tissue sweeps: per step the two triangles between the tips
  /// and the points where the shaft, along -z from the tip, leaves the tissue.
  double tissue_damage_mm2 = 0.0;
};

struct MetricOptions {
  double speed_window_s = 0.1;  ///< > 0. Shorter ones measure the jitter of the tracker.
  double needle_length_mm =
      300;  ///< > 0. How far along the shaft the tissue's surface is looked for.
  /// An entry is counted if since the last exit the tip moved at least this far outside. >= 0.
  double withdrawal_mm = 5.0;
};

/// @throws InputError if an option is out of its range. All zero if fewer than two samples are
/// valid.
MotionMetrics ComputeMotionMetrics(const session::PoseStream& stream,
                                   const MetricOptions& options = {});

/// @throws InputError as above.
TissueMetrics ComputeTissueMetrics(const session::PoseStream& needle, const InsideTissue& inside,
                                   const MetricOptions& options = {});

/// Where the shaft leaves the tissue, going from a tip in tissue along the needle's -z: exact to
/// 1e-6 mm, but tissue or gaps thinner than 0.5 mm may be stepped over. The far end of the shaft if
/// it does not leave the tissue within `length_mm`.
Eigen::Vector3d ShaftExit(const Eigen::Isometry3d& reference_from_needle,
                          const InsideTissue& inside, double length_mm);

}  // namespace acus::training
