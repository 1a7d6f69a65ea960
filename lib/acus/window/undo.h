// Takes back movements of a virtual hand by mouse and keyboard, one after the other.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "acus/window/hand_steering.h"

namespace acus::window {

/// The poses at which the movements of one hand began. A movement begins after a pause.
class MovementHistory {
 public:
  static constexpr double kPauseS = 0.5;

  /// Call in each image. @param goal  Of the hand.  @param moves  There is input for this hand.
  void Note(const Eigen::Isometry3d& goal, bool moves, double now_s);

  /// Begins to take back the newest remaining movement. False: there is none.
  bool TakeBack();

  /// The way of the next `dt_s` towards the beginning of the movement, at the speed of a held key;
  /// zero if nothing is being taken back. Ends with the next movement by the user.
  ToolWay WayBack(const Eigen::Isometry3d& goal, double dt_s);

 private:
  std::vector<Eigen::Isometry3d> begun_at_;
  std::optional<Eigen::Isometry3d> towards_;
  std::optional<double> moved_s_;  ///< Time of the newest input.
};

}  // namespace acus::window
