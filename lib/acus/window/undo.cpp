#include "acus/window/undo.h"

#include <algorithm>

namespace acus::window {
namespace {

constexpr double kBackRadPerS = 0.5;
constexpr double kThereMm = 0.01;
constexpr double kThereRad = 1e-4;
constexpr std::size_t kMostMovements = 1000;

/// At most `longest` of a vector.
Eigen::Vector3d Shortened(const Eigen::Vector3d& vector, double longest) {
  const double length = vector.norm();
  return length <= longest ? vector : Eigen::Vector3d(vector * (longest / length));
}

}  // namespace

void MovementHistory::Note(const Eigen::Isometry3d& goal, bool moves, double now_s) {
  if (!moves) return;
  towards_.reset();
  if (!moved_s_ || now_s - *moved_s_ > kPauseS) {
    if (begun_at_.size() == kMostMovements) begun_at_.erase(begun_at_.begin());
    begun_at_.push_back(goal);
  }
  moved_s_ = now_s;
}

bool MovementHistory::TakeBack() {
  if (begun_at_.empty()) return false;
  towards_ = begun_at_.back();
  begun_at_.pop_back();
  moved_s_.reset();
  return true;
}

ToolWay MovementHistory::WayBack(const Eigen::Isometry3d& goal, double dt_s) {
  ToolWay way;
  if (!towards_) return way;
  const Eigen::AngleAxisd turn(towards_->linear() * goal.linear().transpose());
  way.way_mm = Shortened(towards_->translation() - goal.translation(), kHeldMmPerS * dt_s);
  way.turn_rad = Shortened(turn.angle() * turn.axis(), kBackRadPerS * dt_s);
  if (way.way_mm.norm() < kThereMm && way.turn_rad.norm() < kThereRad) towards_.reset();
  return way;
}

}  // namespace acus::window
