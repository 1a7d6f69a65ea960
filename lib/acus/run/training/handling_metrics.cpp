#include "acus/run/training/handling_metrics.h"

#include <cmath>

#include "acus/data/volume/label_lookup.h"
#include "acus/run/training/smoothness.h"

namespace acus::training {
namespace {

using session::PoseSample;

constexpr double kProfileHz = 100.0;

Eigen::Vector3d TipOf(const PoseSample& sample) {
  return sample.reference_from_tool.translation();
}

double SecondsOf(std::int64_t from_ns, std::int64_t to_ns) {
  return 1e-9 * static_cast<double>(to_ns - from_ns);
}

/// RMS distance of the probe from its mean position between two times; nothing without two samples.
std::optional<double> WanderMm(const session::PoseStream& probe, std::int64_t from_ns,
                               std::int64_t to_ns) {
  Eigen::Vector3d sum_mm = Eigen::Vector3d::Zero();
  double count = 0.0;
  const auto counts = [&](const PoseSample& sample) {
    return sample.valid && sample.time_ns >= from_ns && sample.time_ns <= to_ns;
  };
  for (const PoseSample& sample : probe) {
    if (!counts(sample)) continue;
    sum_mm += TipOf(sample);
    count += 1.0;
  }
  if (count < 2.0) return std::nullopt;
  const Eigen::Vector3d mean_mm = sum_mm / count;
  double squares = 0.0;
  for (const PoseSample& sample : probe) {
    if (counts(sample)) squares += (TipOf(sample) - mean_mm).squaredNorm();
  }
  return std::sqrt(squares / count);
}

}  // namespace

std::optional<InsertionPhases> FindPhases(const session::Session& session,
                                          const InsideTissue& inside, const PassOptions& options) {
  const auto passes = FindPasses(session.needle, inside, options, SwapTimesNs(session));
  if (passes.empty()) return std::nullopt;
  const NeedlePass& last = passes.back();
  InsertionPhases phases;
  phases.begin_ns = session.start_ns();
  const PoseSample* contact = nullptr;
  for (const PoseSample& sample : session.needle) {
    if (!sample.valid || !inside(TipOf(sample))) continue;
    contact = &sample;
    break;
  }
  phases.contact_ns = phases.aim_ns = contact->time_ns;
  for (auto sample = session.needle.rbegin(); sample != session.needle.rend(); ++sample) {
    if (!sample->valid || sample->time_ns > phases.contact_ns) continue;
    if ((TipOf(*sample) - TipOf(*contact)).norm() > kNearEntryMm) break;
    phases.aim_ns = sample->time_ns;
  }
  phases.deepest_ns = phases.end_ns = last.end_ns;
  bool arrived = false;
  for (const PoseSample& sample : session.needle) {
    if (!sample.valid || sample.time_ns < last.begin_ns) continue;
    const bool is_there = (TipOf(sample) - last.tip_mm).norm() <= kAtDepthMm;
    if (is_there && !arrived) phases.deepest_ns = sample.time_ns;
    if (arrived && !is_there && sample.time_ns > last.end_ns) break;
    arrived = arrived || is_there;
    if (arrived) phases.end_ns = sample.time_ns;
  }
  return phases;
}

std::vector<Metric> HandlingMetricsOf(const session::Session& session, const Anatomy& anatomy,
                                      const PassOptions& options) {
  const Eigen::Affine3d index_from_reference =
      anatomy.labels.geometry.index_from_ct() * anatomy.ct_from_reference;
  const auto phases = FindPhases(
      session,
      [&](const Eigen::Vector3d& point_mm) {
        return volume::LabelAt(anatomy.labels, index_from_reference, point_mm) != 0;
      },
      options);
  if (!phases) return {};
  std::vector<Metric> metrics = {
      {"time of search", "s", SecondsOf(phases->begin_ns, phases->aim_ns)},
      {"time of aiming", "s", SecondsOf(phases->aim_ns, phases->contact_ns)},
      {"time of advance", "s", SecondsOf(phases->contact_ns, phases->deepest_ns)},
      {"time at depth", "s", SecondsOf(phases->deepest_ns, phases->end_ns)}};
  const auto speed =
      SpeedProfile(session.needle, phases->contact_ns, phases->deepest_ns, kProfileHz);
  if (speed.size() >= 3) {
    metrics.push_back(
        {"needle smoothness, spectral arc length", "", SpectralArcLength(speed, kProfileHz)});
    metrics.push_back(
        {"needle smoothness, log dimensionless jerk", "", LogDimensionlessJerk(speed, kProfileHz)});
  }
  if (const auto wander_mm = WanderMm(session.probe, phases->contact_ns, phases->deepest_ns)) {
    metrics.push_back({"probe wander during the advance", "mm", *wander_mm});
  }
  return metrics;
}

}  // namespace acus::training
