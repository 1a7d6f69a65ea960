#include "acus/run/training/motion_metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "acus/base/core/error.h"

namespace acus::training {
namespace {

constexpr double kShaftStepMm = 0.5;
constexpr double kExitToleranceMm = 1e-6;
constexpr double kSecondsPerNs = 1e-9;

void Check(const MetricOptions& options) {
  ACUS_REQUIRE(options.speed_window_s > 0.0 && std::isfinite(options.speed_window_s),
               "speed_window_s is ", options.speed_window_s, "; it must be positive");
  ACUS_REQUIRE(options.needle_length_mm > 0.0 && options.needle_length_mm <= 1e4,
               "needle_length_mm is ", options.needle_length_mm, "; it must lie in (0, 10000]");
  ACUS_REQUIRE(options.withdrawal_mm >= 0.0 && std::isfinite(options.withdrawal_mm),
               "withdrawal_mm is ", options.withdrawal_mm, "; it must not be negative");
}

std::vector<const session::PoseSample*> ValidSamples(const session::PoseStream& stream) {
  std::vector<const session::PoseSample*> valid;
  for (const session::PoseSample& sample : stream) {
    if (sample.valid) valid.push_back(&sample);
  }
  return valid;
}

Eigen::Vector3d Origin(const session::PoseSample& sample) {
  return sample.reference_from_tool.translation();
}

double SecondsBetween(const session::PoseSample& a, const session::PoseSample& b) {
  return static_cast<double>(b.time_ns - a.time_ns) * kSecondsPerNs;
}

double TriangleArea(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  return 0.5 * (b - a).cross(c - a).norm();
}

/// Largest distance over its time, of pieces that last at least the window (all of it, if it is
/// shorter).
double MaxSpeed(const std::vector<const session::PoseSample*>& samples, double window_s) {
  double fastest = 0.0;
  std::size_t begin = 0;
  for (std::size_t end = 1; end < samples.size(); ++end) {
    while (begin + 1 < end && SecondsBetween(*samples[begin + 1], *samples[end]) >= window_s) {
      ++begin;
    }
    const double time_s = SecondsBetween(*samples[begin], *samples[end]);
    const bool is_piece = time_s >= window_s || (begin == 0 && end + 1 == samples.size());
    if (!is_piece) continue;
    fastest = std::max(fastest, (Origin(*samples[end]) - Origin(*samples[begin])).norm() / time_s);
  }
  return fastest;
}

}  // namespace

void PathMeter::Add(const session::PoseSample& sample) {
  newest_mm_ = Origin(sample);
  if (!pacer_.Takes(sample.time_ns)) return;
  if (taken_mm_) length_mm_ += (newest_mm_ - *taken_mm_).norm();
  taken_mm_ = newest_mm_;
}

void PathMeter::Restart() {
  length_mm_ = length_mm();
  taken_mm_.reset();
  pacer_.Restart();
}

double PathMeter::length_mm() const {
  return length_mm_ + (taken_mm_ ? (newest_mm_ - *taken_mm_).norm() : 0.0);
}

MotionMetrics ComputeMotionMetrics(const session::PoseStream& stream, const MetricOptions& options,
                                   std::span<const std::int64_t> swaps_ns) {
  Check(options);
  MotionMetrics metrics;
  const auto samples = ValidSamples(stream);
  if (samples.size() < 2) return metrics;
  SwapWatch swaps(swaps_ns);
  swaps.Passes(samples.front()->time_ns);
  std::vector<const session::PoseSample*> held;  // Samples by one hand.
  PathMeter path;
  const auto end_hold = [&] {
    metrics.max_speed_mm_per_s =
        std::max(metrics.max_speed_mm_per_s, MaxSpeed(held, options.speed_window_s));
    held.clear();
  };
  for (const session::PoseSample* sample : samples) {
    if (swaps.Passes(sample->time_ns)) {
      end_hold();
      path.Restart();
    }
    held.push_back(sample);
    path.Add(*sample);
  }
  end_hold();
  metrics.path_length_mm = path.length_mm();
  metrics.elapsed_time_s = SecondsBetween(*samples.front(), *samples.back());
  metrics.mean_speed_mm_per_s = metrics.path_length_mm / metrics.elapsed_time_s;
  return metrics;
}

TissueMeter::TissueMeter(InsideTissue inside, const MetricOptions& options)
    : inside_(std::move(inside)), options_(options) {
  Check(options);
}

void TissueMeter::Restart() {
  metrics_ = metrics();
  last_.reset();
  taken_.reset();
  pacer_.Restart();
  was_inside_ = false;
  away_mm_ = std::numeric_limits<double>::infinity();
}

void TissueMeter::Add(const session::PoseSample& sample) {
  if (!sample.valid) return;
  const Eigen::Vector3d tip_mm = Origin(sample);
  const bool is_inside = inside_(tip_mm);
  if (is_inside && last_) metrics_.time_in_tissue_s += SecondsBetween(*last_, sample);
  if (is_inside && !was_inside_ && away_mm_ >= options_.withdrawal_mm) ++metrics_.num_insertions;
  if (is_inside) left_mm_ = tip_mm;
  away_mm_ = is_inside ? 0.0 : std::max(away_mm_, (tip_mm - left_mm_).norm());
  was_inside_ = is_inside;
  last_ = sample;
  if (!pacer_.Takes(sample.time_ns)) return;
  const Shaft shaft = ShaftOf(sample, is_inside);
  if (taken_) AddStep(*taken_, shaft, metrics_);
  taken_ = shaft;
}

TissueMeter::Shaft TissueMeter::ShaftOf(const session::PoseSample& sample, bool is_inside) const {
  const Eigen::Vector3d tip_mm = Origin(sample);
  return {.tip_mm = tip_mm,
          .exit_mm = is_inside
                         ? ShaftExit(sample.reference_from_tool, inside_, options_.needle_length_mm)
                         : tip_mm,
          .is_inside = is_inside};
}

void TissueMeter::AddStep(const Shaft& from, const Shaft& to, TissueMetrics& metrics) {
  if (to.is_inside) metrics.path_in_tissue_mm += (to.tip_mm - from.tip_mm).norm();
  if (!to.is_inside || !from.is_inside) return;
  metrics.tissue_damage_mm2 += TriangleArea(to.tip_mm, from.tip_mm, to.exit_mm) +
                               TriangleArea(to.exit_mm, from.exit_mm, from.tip_mm);
}

TissueMetrics TissueMeter::metrics() const {
  TissueMetrics metrics = metrics_;
  if (taken_) AddStep(*taken_, ShaftOf(*last_, was_inside_), metrics);
  return metrics;
}

TissueMetrics ComputeTissueMetrics(const session::PoseStream& needle, const InsideTissue& inside,
                                   const MetricOptions& options,
                                   std::span<const std::int64_t> swaps_ns) {
  TissueMeter meter(inside, options);
  SwapWatch swaps(swaps_ns);
  for (const session::PoseSample& sample : needle) {
    if (swaps.Passes(sample.time_ns)) meter.Restart();
    meter.Add(sample);
  }
  return meter.metrics();
}

std::vector<std::int64_t> SwapTimesNs(const session::Session& session) {
  std::vector<std::int64_t> times_ns;
  for (const session::Command& command : session.commands) {
    if (command.kind == session::CommandKind::kSwapHands) times_ns.push_back(command.time_ns);
  }
  return times_ns;
}

Eigen::Vector3d ShaftExit(const Eigen::Isometry3d& reference_from_needle,
                          const InsideTissue& inside, double length_mm) {
  const Eigen::Vector3d tip_mm = reference_from_needle.translation();
  const Eigen::Vector3d towards_hub = -reference_from_needle.linear().col(2);
  double in_tissue_mm = 0.0;
  double outside_mm = 0.0;
  do {
    in_tissue_mm = outside_mm;
    outside_mm = std::min(outside_mm + kShaftStepMm, length_mm);
    if (inside(tip_mm + outside_mm * towards_hub)) {
      if (outside_mm >= length_mm) return tip_mm + length_mm * towards_hub;
      continue;
    }
    while (outside_mm - in_tissue_mm > kExitToleranceMm) {
      const double middle_mm = 0.5 * (in_tissue_mm + outside_mm);
      (inside(tip_mm + middle_mm * towards_hub) ? in_tissue_mm : outside_mm) = middle_mm;
    }
    return tip_mm + outside_mm * towards_hub;
  } while (true);
}

}  // namespace acus::training
