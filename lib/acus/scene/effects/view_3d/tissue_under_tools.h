// The tissue that tools press, for a view in three dimensions.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/beam_bend.h"
#include "acus/imaging/volume_rendering/pressed_tissue.h"
#include "acus/physics/breathing/motion_map.h"

namespace acus::effects {

/// Poses of the tools at one instant, CT space; nothing or null: the tool is absent.
struct ToolsOnTissue {
  std::optional<image::NeedleInImage> needle;
  std::optional<Eigen::Isometry3d> ct_from_probe;
  const acoustics::Probe* probe = nullptr;
};

struct PressedDetail {
  int most_knots = 16'000;  ///< Approximate maximum; knots are 1 to 8 mm apart.
  int num_threads = 1;
};

/// The box in which tools can press tissue: within 60 mm of the needle and of the probe's face.
Eigen::AlignedBox3d ReachOf(const ToolsOnTissue& tools);

/// The difference between the whole map from the deformed state to rest and that of breath alone,
/// at knots where it exceeds 0.1 mm and at the knots around them.
/// @param rest  Breath, tools and all else. @param breath  Null or still: the patient is at rest.
/// @param reach  Where to search, in steps of 10 mm; empty: nothing is pressed.
/// @param breath_iterations  As `rest` inverts the breath: points that no tool moves then cancel
///     exactly.
volume_rendering::PressedTissue PressedIn(const slicing::RestMap& rest,
                                          const breathing::MotionMap* breath,
                                          const Eigen::AlignedBox3d& reach,
                                          const PressedDetail& detail, int breath_iterations = 5);

}  // namespace acus::effects
