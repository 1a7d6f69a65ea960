// A breathing body whose motion is known in closed form, and its motion models: the scene of the
// sweep "breathing".
#pragma once

#include <vector>

#include "acus/physics/breathing/model_building.h"
#include "acus/physics/breathing/motion_model.h"

namespace acus::benchmarks {

/// A cavity, the ellipse x/150, y/100 in mm, in a wall; z to the head, LPS. From end inspiration
/// to end expiration organs rise by up to 20 mm around z = 0 and come back another way, 2 mm aside
/// of it; they slide along the wall, which with everything moves back by up to 5 mm in front. The
/// way is not a straight line of the signal: that is what models of it cannot know.
class BreathingBody {
 public:
  static constexpr double kPeriodS = 4.0;
  static constexpr double kSlidingMm = 20.0;

  /// A regular breath (Lujan, exponent 2) of this depth: level 1 at inspiration, 1 - depth half
  /// way.
  static breathing::Breath BreathAt(double cycle, double depth = 1.0);

  static Eigen::Vector3d DisplacementMm(const breathing::Breath& breath,
                                        const Eigen::Vector3d& rest_mm);
  /// Distance to the wall along which organs slide, about; negative in the cavity.
  static double FromWallMm(const Eigen::Vector3d& rest_mm);

  /// Nodes over the whole body, `per_axis` along each axis.
  static volume::Geometry Nodes(int per_axis);
  static std::vector<float> Field(const volume::Geometry& nodes, const breathing::Breath& breath);
  /// A 4D CT of `count` phases at equal steps of the cycle. The first is the reference.
  static breathing::MotionPhases Phases(int per_axis, int count);

  /// Random places of the body, the same each time, at least `off_wall_mm` from the wall.
  static std::vector<Eigen::Vector3d> Places(int count, double off_wall_mm);
  /// Within `off_wall_mm` of it.
  static std::vector<Eigen::Vector3d> PlacesAtWall(int count, double off_wall_mm);
};

}  // namespace acus::benchmarks
