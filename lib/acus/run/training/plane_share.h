// The share of time in which the image shows the needle.
#pragma once

#include <optional>

#include "acus/run/training/motion_metrics.h"

namespace acus::training {

struct PlaneOptions {
  /// Half the slice thickness: 2 mm is typical of a linear probe at its focus.
  double half_thickness_mm = 2.0;  ///< > 0
  /// The needle is in the plane if its tip and the point of its shaft at this distance are. > 0.
  double shaft_mm = 20.0;
};

/// Shares of the time in which the tip is in tissue and both tools are seen.
struct PlaneShare {
  double seconds = 0.0;
  double tip_percent = 0.0;     ///< The tip lies in the image plane. 0 if `seconds` is.
  double needle_percent = 0.0;  ///< The tip and the point shaft_mm behind it do.
};

/// True if a point of the session's reference frame lies in the image plane of a probe.
bool IsInPlane(const Eigen::Vector3d& point_mm, const transforms::Pose& reference_from_probe,
               const PlaneOptions& options);

/// PlaneShare of samples as they arrive. Steps count as in tissue, and as in the plane, if their
/// end is.
class PlaneMeter {
 public:
  /// @throws InputError if an option is out of its range.
  PlaneMeter(InsideTissue inside, const PlaneOptions& options);

  void Add(const session::PoseSample& needle, const session::PoseSample& probe);
  PlaneShare share() const;

 private:
  InsideTissue inside_;
  PlaneOptions options_;
  double seconds_ = 0.0;
  double tip_s_ = 0.0;
  double needle_s_ = 0.0;
  std::optional<std::int64_t> last_ns_;  ///< Time of the last sample, if it was valid.
};

/// PlaneShare of a whole session.
/// @throws InputError if an option is out of its range.
PlaneShare ComputePlaneShare(const session::Session& session, const InsideTissue& inside,
                             const PlaneOptions& options = {});

}  // namespace acus::training
