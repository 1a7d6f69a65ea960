// How good a tracker is: jitter of a tool that lies still, accuracy over known distances.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "acus/data/session/session.h"
#include "acus/data/transforms/landmarks.h"

namespace acus::registration {

/// Jitter of one tool, from samples [first, last] in which it lay still.
struct Jitter {
  std::string tool;
  std::size_t first = 0;
  std::size_t last = 0;
  std::size_t num_samples = 0;   ///< Valid ones among them.
  std::size_t num_invalid = 0;   ///< Of the whole recording.
  std::size_t num_repeated = 0;  ///< Poses equal to the one before in every bit.
  double duration_s = 0.0;
  double rate_hz = 0.0;          ///< From the median interval.
  bool whole_recording = false;  ///< It lay still throughout.
  Eigen::Vector3d mean_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d sd_mm = Eigen::Vector3d::Zero();  ///< Per axis of the reference frame.
  double rms_mm = 0.0;  ///< Distance from the mean, RMS: the jitter of the 2010 paper.
  double p95_mm = 0.0;  ///< 95 % of the samples are nearer to the mean.
  double largest_mm = 0.0;
  double rms_deg = 0.0;   ///< Angle to the mean rotation, RMS.
  double drift_mm = 0.0;  ///< Length of the straight trend, from first to last.
  /// Noise from sample to sample, RMS length, from second differences (which take out steady
  /// motion). Below rms_mm if neighbours err alike: filtering, drift.
  double noise_mm = 0.0;
  double step_mm = 0.0;  ///< Smallest difference of a coordinate: the resolution of the numbers.
};

/// The jitter over the longest stretch in which the tool stays within a box of diagonal `still_mm`
/// (0.1 s means, so that jitter itself does not end it).
/// @throws InputError if the stream has fewer than 10 valid samples or still_mm is not positive.
/// @throws NoAnswerError if it lay still for less than a second.
Jitter MeasureJitter(const session::PoseStream& reference_from_tool, const std::string& tool,
                     double still_mm);

/// Errors of measured places whose true layout is known in some frame of its own.
struct PlaceAccuracy {
  std::vector<std::string> names;
  struct Distance {
    Eigen::Index from = 0;
    Eigen::Index to = 0;
    double true_mm = 0.0;
    double error_mm = 0.0;  ///< Measured minus true.
  };
  std::vector<Distance> distances;  ///< All pairs.
  double rms_mm = 0.0;      ///< Of the errors of the distances: the accuracy of the 2010 paper.
  double mean_mm = 0.0;     ///< Their mean, with sign.
  double largest_mm = 0.0;  ///< Largest size.
  double scale = 1.0;       ///< Measured lengths over true ones, least squares.
  bool has_places = false;  ///< There are three places off a line: those below are known.
  Eigen::VectorXd place_error_mm;  ///< After the best rigid fit.
  double place_rms_mm = 0.0;
};

/// @throws InputError if there are fewer than two places, or two are at the same place.
PlaceAccuracy MeasureAccuracy(const transforms::MarkerPairs& measured_and_true);

}  // namespace acus::registration
