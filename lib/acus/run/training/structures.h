// Which tissues the tip of the needle went through.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "acus/data/session/session.h"
#include "acus/data/volume/volume.h"

namespace acus::training {

/// The label at a point of the session's reference frame (mm).
using LabelAtPoint = std::function<volume::Label(const Eigen::Vector3d& point_in_reference_mm)>;

struct StructureEntered {
  volume::Label label = 0;
  /// The tip went in; again only after it has moved kReentryMm outside.
  int num_entries = 0;
  double path_mm = 0.0;  ///< Of the tip within it.
  std::int64_t first_ns = 0;
};

inline constexpr double kReentryMm = 1.0;

/// All labels but 0 that the tip was in, in order of label. The way between two samples is straight
/// and is looked at every 0.25 mm, so that a quick stab through a thin vessel is seen.
std::vector<StructureEntered> StructuresEntered(const session::PoseStream& needle,
                                                const LabelAtPoint& label_at);

}  // namespace acus::training
