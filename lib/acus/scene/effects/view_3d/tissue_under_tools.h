// What tools press of the tissue, for a view in three dimensions.
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

/// Tools of a moment, CT space; nothing or null: not there.
struct ToolsOnTissue {
  std::optional<image::NeedleInImage> needle;
  std::optional<Eigen::Isometry3d> ct_from_probe;
  const acoustics::Probe* probe = nullptr;
};

struct PressedDetail {
  int most_knots = 16'000;  ///< About as many; they are 1 to 8 mm apart.
  int num_threads = 1;
};

/// Where tools can press tissue: what lies within 60 mm of the needle and of the probe's face.
Eigen::AlignedBox3d ReachOf(const ToolsOnTissue& tools);

/// The difference between the whole map from the world to rest and that of breath alone, at knots
/// where it is more than 0.1 mm and around them.
/// @param rest  Breath, tools and all else. @param breath  Null or still: the patient is at rest.
/// @param reach  Where to look, every 10 mm; empty: nothing is pressed.
/// @param breath_iterations  As `rest` inverts the breath: places that no tool moves then cancel to
///     the bit.
volume_rendering::PressedTissue PressedIn(const slicing::RestMap& rest,
                                          const breathing::MotionMap* breath,
                                          const Eigen::AlignedBox3d& reach,
                                          const PressedDetail& detail, int breath_iterations = 5);

}  // namespace acus::effects
