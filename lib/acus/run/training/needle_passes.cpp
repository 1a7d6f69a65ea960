#include "acus/run/training/needle_passes.h"

#include <cmath>
#include <utility>

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

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

PassMeter::TurnFinder::TurnFinder(double turn_mm, int attempt, const PoseSample& entry)
    : turn_mm_(turn_mm), attempt_(attempt), begin_{0.0, entry}, extreme_(begin_) {}

std::optional<NeedlePass> PassMeter::TurnFinder::Add(double step_mm, const PoseSample& sample) {
  way_mm_ += step_mm;
  const double sign = advancing_ ? 1.0 : -1.0;
  if (sign * (way_mm_ - extreme_.way_mm) >= 0.0) {
    extreme_ = {way_mm_, sample};
    return std::nullopt;
  }
  if (std::abs(way_mm_ - extreme_.way_mm) < turn_mm_) return std::nullopt;
  const std::optional<NeedlePass> ended = Ended();
  advancing_ = !advancing_;
  begin_ = extreme_;
  extreme_ = {way_mm_, sample};
  return ended;
}

std::optional<NeedlePass> PassMeter::TurnFinder::Ended() const {
  if (!advancing_ || extreme_.way_mm - begin_.way_mm < turn_mm_) return std::nullopt;
  const auto& pose = extreme_.sample.reference_from_tool;
  return NeedlePass{
      begin_.sample.time_ns, extreme_.sample.time_ns, attempt_, extreme_.way_mm - begin_.way_mm,
      pose.linear().col(2),  pose.translation(),      false};
}

PassMeter::PassMeter(InsideTissue inside, const PassOptions& options)
    : inside_(std::move(inside)), options_(options) {
  Check(options);
}

void PassMeter::Keep(std::vector<NeedlePass>& passes, const std::optional<NeedlePass>& pass) const {
  if (!pass) return;
  passes.push_back(*pass);
  if (passes.size() < 2) return;
  const NeedlePass& before = passes[passes.size() - 2];
  passes.back().redirected = before.attempt == pass->attempt &&
                             AngleBetween(before.axis, pass->axis) >= options_.redirection_rad;
}

void PassMeter::Add(const PoseSample& sample) {
  if (!sample.valid) return;
  const Eigen::Vector3d tip_mm = sample.reference_from_tool.translation();
  const Eigen::Vector3d motion_mm = tip_mm - last_mm_.value_or(tip_mm);
  last_mm_ = tip_mm;
  if (turns_) {
    Keep(ended_, turns_->Add(motion_mm.dot(sample.reference_from_tool.linear().col(2)), sample));
  }
  if (inside_(tip_mm)) {
    if (!turns_) turns_.emplace(options_.turn_mm, num_attempts_++, sample);
    left_mm_ = tip_mm;
    return;
  }
  if (!turns_ || (tip_mm - left_mm_).norm() < options_.withdrawal_mm) return;
  Keep(ended_, turns_->Ended());
  turns_.reset();
}

void PassMeter::Restart() {
  if (turns_) Keep(ended_, turns_->Ended());
  turns_.reset();
  last_mm_.reset();
}

std::vector<NeedlePass> PassMeter::passes() const {
  std::vector<NeedlePass> passes = ended_;
  if (turns_) Keep(passes, turns_->Ended());
  return passes;
}

std::vector<NeedlePass> FindPasses(const session::PoseStream& needle, const InsideTissue& inside,
                                   const PassOptions& options,
                                   std::span<const std::int64_t> swaps_ns) {
  PassMeter meter(inside, options);
  SwapWatch swaps(swaps_ns);
  for (const PoseSample& sample : needle) {
    if (swaps.Passes(sample.time_ns)) meter.Restart();
    meter.Add(sample);
  }
  return meter.passes();
}

}  // namespace acus::training
