#include "acus/run/training/needle_passes.h"

#include <cmath>
#include <optional>

#include "acus/base/core/error.h"

namespace acus::training {
namespace {

using session::PoseSample;

void Check(const PassOptions& options) {
  ACUS_REQUIRE(options.turn_mm > 0.0 && std::isfinite(options.turn_mm), "turn_mm is ",
               options.turn_mm, "; it must be positive");
  ACUS_REQUIRE(options.redirection_rad > 0.0 && options.redirection_rad < 3.2,
               "redirection_rad is ", options.redirection_rad, "; it must lie in (0, 3.2)");
  ACUS_REQUIRE(options.withdrawal_mm >= 0.0 && std::isfinite(options.withdrawal_mm),
               "withdrawal_mm is ", options.withdrawal_mm, "; it must not be negative");
}

struct Turn {
  double way_mm = 0.0;
  const PoseSample* sample = nullptr;
};

/// Follows the way along the shaft within one attempt and finds where it turns.
class TurnFinder {
 public:
  TurnFinder(double turn_mm, int attempt, const PoseSample& entry)
      : turn_mm_(turn_mm), attempt_(attempt), begin_{0.0, &entry}, extreme_(begin_) {}

  /// The pass that ends because the needle has been drawn back, if it has.
  std::optional<NeedlePass> Add(double step_mm, const PoseSample& sample) {
    way_mm_ += step_mm;
    const double sign = advancing_ ? 1.0 : -1.0;
    if (sign * (way_mm_ - extreme_.way_mm) >= 0.0) {
      extreme_ = {way_mm_, &sample};
      return std::nullopt;
    }
    if (std::abs(way_mm_ - extreme_.way_mm) < turn_mm_) return std::nullopt;
    const std::optional<NeedlePass> ended = Ended();
    advancing_ = !advancing_;
    begin_ = extreme_;
    extreme_ = {way_mm_, &sample};
    return ended;
  }

  /// The pass that ends at the deepest point so far, if it is long enough for one.
  std::optional<NeedlePass> Ended() const {
    if (!advancing_ || extreme_.way_mm - begin_.way_mm < turn_mm_) return std::nullopt;
    const auto& pose = extreme_.sample->reference_from_tool;
    return NeedlePass{
        begin_.sample->time_ns, extreme_.sample->time_ns, attempt_, extreme_.way_mm - begin_.way_mm,
        pose.linear().col(2),   pose.translation(),       false};
  }

 private:
  double turn_mm_;
  int attempt_;
  bool advancing_ = true;
  double way_mm_ = 0.0;
  Turn begin_;    ///< Where this way forward or back began.
  Turn extreme_;  ///< The farthest that it went.
};

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

std::vector<NeedlePass> FindPasses(const session::PoseStream& needle, const InsideTissue& inside,
                                   const PassOptions& options) {
  Check(options);
  std::vector<NeedlePass> passes;
  const auto keep = [&](const std::optional<NeedlePass>& pass) {
    if (!pass) return;
    passes.push_back(*pass);
    if (passes.size() < 2) return;
    const NeedlePass& before = passes[passes.size() - 2];
    passes.back().redirected = before.attempt == pass->attempt &&
                               AngleBetween(before.axis, pass->axis) >= options.redirection_rad;
  };
  std::optional<TurnFinder> turns;  // While an attempt lasts.
  int num_attempts = 0;
  double outside_mm = 0.0;  // Path since the last exit.
  const PoseSample* last = nullptr;
  for (const PoseSample& sample : needle) {
    if (!sample.valid) continue;
    const Eigen::Vector3d tip_mm = sample.reference_from_tool.translation();
    Eigen::Vector3d motion_mm = Eigen::Vector3d::Zero();
    if (last != nullptr) motion_mm = tip_mm - last->reference_from_tool.translation();
    if (turns) keep(turns->Add(motion_mm.dot(sample.reference_from_tool.linear().col(2)), sample));
    if (inside(tip_mm)) {
      if (!turns) turns.emplace(options.turn_mm, num_attempts++, sample);
      outside_mm = 0.0;
    } else {
      outside_mm += motion_mm.norm();
      if (turns && outside_mm >= options.withdrawal_mm) {
        keep(turns->Ended());
        turns.reset();
      }
    }
    last = &sample;
  }
  if (turns) keep(turns->Ended());
  return passes;
}

}  // namespace acus::training
