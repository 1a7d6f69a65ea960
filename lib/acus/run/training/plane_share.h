// How much of the time the image shows the needle.
#pragma once

#include "acus/run/training/motion_metrics.h"

namespace acus::training {

struct PlaneOptions {
  /// Half the thickness of what the image shows: 2 mm is typical of a linear probe in its focus.
  double half_thickness_mm = 2.0;  ///< > 0
  /// The needle is in the plane if its tip and the point of its shaft this far up are. > 0.
  double shaft_mm = 20.0;
};

/// Of the time that the tip is in tissue and both tools are seen.
struct PlaneShare {
  double seconds = 0.0;
  double tip_percent = 0.0;     ///< The tip lies in the image plane. 0 if `seconds` is.
  double needle_percent = 0.0;  ///< The tip and the shaft behind it do.
};

/// Steps count as in tissue, and as in the plane, if their end is.
/// @throws InputError if an option is out of its range.
PlaneShare ComputePlaneShare(const session::Session& session, const InsideTissue& inside,
                             const PlaneOptions& options = {});

}  // namespace acus::training
