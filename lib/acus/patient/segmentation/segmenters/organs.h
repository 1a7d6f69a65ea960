// Organs that are distinguished from their neighbours from seed points.
#pragma once

#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {

struct OrganSeed {
  std::string tissue;                      ///< A standard label: "liver", "kidney", ...
  std::vector<Eigen::Vector3d> points_mm;  ///< Inside the organ, LPS.
  enum class Method { kRegionGrowing, kLevelSet } method = Method::kRegionGrowing;
  double lower_hu = 0.0;
  double upper_hu = 0.0;
  double radius_mm = 0.0;         ///< Nothing farther than this from every seed is taken.
  double smoothing_mm = 0.0;      ///< Radius of the ball that cuts leaks and closes vessels.
  double curvature_weight = 1.0;  ///< Level set only: how smooth the front is kept.
  int iterations = 0;             ///< Level set only.
};

/// The organ around its seeds.
///
/// Region growing (ITK ConnectedThreshold): voxels within [lower_hu, upper_hu] of the
/// median-filtered CT that hang together with a seed, opened by a ball against leaks, then closed.
/// Level set (ITK ThresholdSegmentationLevelSet): a front that starts at balls around the seeds and
/// moves with the distance of the CT value from the ends of the range, held smooth by its
/// curvature.
///
/// @throws InputError if a seed is outside the volume or its surroundings outside the range (the
///     message gives the HU there).
/// @throws NoAnswerError if nothing remains.
Mask FindOrgan(const volume::CtVolume& ct, const OrganSeed& organ, const RunContext& context);

}  // namespace acus::segmentation
