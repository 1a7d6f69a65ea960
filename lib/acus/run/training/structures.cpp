#include "acus/run/training/structures.h"

#include <algorithm>
#include <cmath>

#include "acus/run/training/motion_metrics.h"

namespace acus::training {
namespace {

constexpr double kLookMm = 0.25;
/// A longer motion between two samples is a jump of the tracker, not a stab.
constexpr double kLongestMm = 50.0;

/// Calls `look` at the end of each piece of the line between two samples, with its length, mm.
template <typename Look>
void Walk(const Eigen::Vector3d& from_mm, const Eigen::Vector3d& to_mm, const Look& look) {
  const double way_mm = (to_mm - from_mm).norm();
  const int looks =
      way_mm > kLongestMm ? 1 : std::max(1, static_cast<int>(std::ceil(way_mm / kLookMm)));
  for (int i = 1; i <= looks; ++i) {
    look(from_mm + (static_cast<double>(i) / looks) * (to_mm - from_mm), way_mm / looks);
  }
}

}  // namespace

void StructureMeter::Look(const Eigen::Vector3d& tip_mm, std::int64_t time_ns) {
  const volume::Label label = label_at_(tip_mm);
  for (auto& [other, visit] : visits_) {
    if (other != label) visit.away_mm = std::max(visit.away_mm, (tip_mm - visit.left_mm).norm());
  }
  if (label == 0) return;
  Visit& visit = visits_[label];
  StructureEntered& entered = visit.so_far;
  if (entered.num_entries == 0) {
    entered.label = label;
    entered.first_ns = time_ns;
  }
  if (visit.away_mm >= kReentryMm) ++entered.num_entries;
  visit.left_mm = tip_mm;
  visit.away_mm = 0.0;
}

/// The path from the last sample taken to the newest.
void StructureMeter::AddPathTo(std::map<volume::Label, Visit>& visits) const {
  if (!taken_mm_ || !last_mm_) return;
  Walk(*taken_mm_, *last_mm_, [&](const Eigen::Vector3d& tip_mm, double step_mm) {
    const auto visit = visits.find(label_at_(tip_mm));
    if (visit != visits.end()) visit->second.so_far.path_mm += step_mm;
  });
}

void StructureMeter::Add(const session::PoseSample& sample) {
  if (!sample.valid) return;
  const Eigen::Vector3d to_mm = sample.reference_from_tool.translation();
  Walk(last_mm_.value_or(to_mm), to_mm,
       [&](const Eigen::Vector3d& tip_mm, double) { Look(tip_mm, sample.time_ns); });
  last_mm_ = to_mm;
  if (!pacer_.Takes(sample.time_ns)) return;
  AddPathTo(visits_);
  taken_mm_ = to_mm;
}

void StructureMeter::Restart() {
  AddPathTo(visits_);
  last_mm_.reset();
  taken_mm_.reset();
  pacer_.Restart();
}

std::vector<StructureEntered> StructureMeter::entered() const {
  auto visits = visits_;
  AddPathTo(visits);
  std::vector<StructureEntered> entered;
  for (const auto& [label, visit] : visits) entered.push_back(visit.so_far);
  return entered;
}

int StructureMeter::EntriesInto(std::span<const volume::Label> labels) const {
  int entries = 0;
  for (const volume::Label label : labels) {
    const auto visit = visits_.find(label);
    if (visit != visits_.end()) entries += visit->second.so_far.num_entries;
  }
  return entries;
}

std::vector<StructureEntered> StructuresEntered(const session::PoseStream& needle,
                                                const LabelAtPoint& label_at,
                                                std::span<const std::int64_t> swaps_ns) {
  StructureMeter meter(label_at);
  SwapWatch swaps(swaps_ns);
  for (const session::PoseSample& sample : needle) {
    if (swaps.Passes(sample.time_ns)) meter.Restart();
    meter.Add(sample);
  }
  return meter.entered();
}

}  // namespace acus::training
