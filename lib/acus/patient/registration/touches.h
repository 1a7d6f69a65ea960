// Places that a pointer touched, found in its recording: where the tip rested.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "acus/data/session/session.h"
#include "acus/data/transforms/landmarks.h"

namespace acus::registration {

/// How PLUS (vtkPlusLandmarkDetectionAlgo) finds landmarks, and its defaults, except
/// for the shaft: a pointer that stands still is as good here as one that pivots.
struct TouchSettings {
  double window_s = 0.2;       ///< > 0. The tip is averaged over windows before it is looked at.
  double still_mm = 1.5;       ///< > 0. The windows' means stay within a box with this diagonal ...
  double least_s = 1.0;        ///< >= window_s. ... for this long.
  double shaft_mm = 0.0;       ///< >= 0. A point of the shaft 100 mm above moves by this much.
  double same_place_mm = 5.0;  ///< >= 0. A rest nearer than this to an earlier one adds to it.
  /// What of the first rest at a place is averaged, from its start. By default all of it and of
  /// later rests there, except for samples more than three times the median distance from the
  /// median.
  double average_from_s = 0.0;
  double average_to_s = std::numeric_limits<double>::infinity();
};

struct Touch {
  Eigen::Vector3d reference_mm = Eigen::Vector3d::Zero();  ///< Mean of the tip.
  double rms_mm = 0.0;                                     ///< Of the tip's distance from it.
  std::int64_t start_ns = 0;                               ///< Of the first rest there.
  std::int64_t end_ns = 0;                                 ///< Of the last one.
  std::size_t num_samples = 0;
};

/// In order of their first rest. Invalid samples are passed over.
/// @param tip_mm  In the tool's frame, from a pivot calibration.
/// @throws InputError if a setting is out of its range or the stream has fewer than two samples.
std::vector<Touch> FindTouches(const session::PoseStream& reference_from_tool,
                               const Eigen::Vector3d& tip_mm, const TouchSettings& settings);

/// Those of too many rests (the pointer lay on the table before) whose layout is that of the
/// points, in their order: the best choice, if it fits to a twentieth of their spread and no other
/// fits within three times its FRE. All touches where there are not too many, or it is not clear.
std::vector<Touch> ChooseTouches(const std::vector<Touch>& touches,
                                 const transforms::Landmarks& known);

/// The touches as landmarks, named like the points they should be, in order.
/// @throws InputError if there are not as many as points, saying when each was found.
transforms::Landmarks NamedTouches(const std::vector<Touch>& touches,
                                   const transforms::Landmarks& known, const std::string& source);

/// Every valid position of the tip at least `spacing_mm` from the one kept before: a swept surface.
transforms::Landmarks SweptPoints(const session::PoseStream& reference_from_tool,
                                  const Eigen::Vector3d& tip_mm, double spacing_mm,
                                  const std::string& source);

}  // namespace acus::registration
