// Temporal calibration: by how much the clocks of two recordings of one motion differ.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "acus/data/session/session.h"

namespace acus::registration {

/// Numbers that follow the motion of a body, such as its position, or the row of a line in an
/// image.
struct MotionSignal {
  std::vector<std::int64_t> time_ns;  ///< Strictly increasing.
  Eigen::MatrixXd values;             ///< One row per time; any unit.
};

/// The valid positions of a tool, mm.
MotionSignal PositionsOf(const session::PoseStream& stream);

struct TemporalSettings {
  double max_lag_s = 1.0;    ///< > 0. Lags up to this, either way, are searched.
  double least_share = 0.8;  ///< Of the signal's variance, that the motion must explain.
};

struct TemporalCalibration {
  double lag_s = 0.0;            ///< Added to the signal's times, they are those of the tracker.
  double sd_s = 0.0;             ///< Standard error of the lag.
  double half_width_s = 0.0;     ///< Of its 95 % interval: Student's t times the standard error.
  double explained_share = 0.0;  ///< Of the signal's variance, at this lag.
  std::size_t num_samples = 0;
  int num_cycles = 0;  ///< Of the motion: what the standard error is estimated from ...
  std::vector<double> detector_lag_s;  ///< ... and from these, if there are several.
  std::vector<double> searched_lag_s;  ///< The lags that were tried ...
  std::vector<double> searched_share;  ///< ... and what each explains.
};

/// The lag at which the tracked motion explains the signal best.
///
/// Every point that is fixed to a rigid body moves linearly with the body's position and rotation
/// matrix (12 numbers), in whatever frame it is given. So the signal is predicted from these at the
/// times t + lag by linear least squares, and the lag with the smallest residual is refined by a
/// parabola. The recordings may have different frames, units and rates.
///
/// The standard error is that of clusters: what each cycle of the motion contributes to the lag
/// scatters, whatever the residuals within a cycle have in common (drift, outliers, quantised
/// values). Several detectors, such as the edges and the middle of a line, give their mean; each
/// has a lag of its own where the image of the line changes as it moves, and the scatter between
/// them is part of the standard error. With one detector such an error cannot be seen.
/// @param tracker  Poses, valid ones are interpolated.
/// @throws InputError if the recordings have fewer than 40 samples in common.
/// @throws NoAnswerError if nothing moves, the motion explains too little of the signal, the best
///     lag is at the end of the search, or another lag is as good (periodic motion).
TemporalCalibration CalibrateTime(const session::PoseStream& tracker, const MotionSignal& signal,
                                  const TemporalSettings& settings = {});

/// The same with several detectors of one motion, all with the same times: those that have an
/// answer count alike. @throws NoAnswerError as the first detector, if none has.
TemporalCalibration CalibrateTime(const session::PoseStream& tracker,
                                  std::span<const MotionSignal> detectors,
                                  const TemporalSettings& settings = {});

}  // namespace acus::registration
