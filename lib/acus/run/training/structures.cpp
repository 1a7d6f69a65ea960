#include "acus/run/training/structures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace acus::training {
namespace {

constexpr double kLookMm = 0.25;
/// More looks than this between two samples are a jump of the tracker, not a stab.
constexpr double kLongestMm = 50.0;

struct Visit {
  StructureEntered so_far;
  double outside_mm = std::numeric_limits<double>::infinity();  ///< Since the tip was last in it.
};

}  // namespace

std::vector<StructureEntered> StructuresEntered(const session::PoseStream& needle,
                                                const LabelAtPoint& label_at) {
  std::map<volume::Label, Visit> visits;
  const auto look = [&](const Eigen::Vector3d& tip_mm, double step_mm, std::int64_t time_ns) {
    const volume::Label label = label_at(tip_mm);
    for (auto& [other, visit] : visits) {
      if (other != label) visit.outside_mm += step_mm;
    }
    if (label == 0) return;
    Visit& visit = visits[label];
    StructureEntered& entered = visit.so_far;
    if (entered.num_entries == 0) {
      entered.label = label;
      entered.first_ns = time_ns;
    }
    if (visit.outside_mm >= kReentryMm) ++entered.num_entries;
    visit.outside_mm = 0.0;
    entered.path_mm += step_mm;
  };
  const session::PoseSample* last = nullptr;
  for (const session::PoseSample& sample : needle) {
    if (!sample.valid) continue;
    const Eigen::Vector3d to_mm = sample.reference_from_tool.translation();
    const Eigen::Vector3d from_mm =
        last == nullptr ? to_mm : Eigen::Vector3d(last->reference_from_tool.translation());
    last = &sample;
    const double way_mm = (to_mm - from_mm).norm();
    const int looks =
        way_mm > kLongestMm ? 1 : std::max(1, static_cast<int>(std::ceil(way_mm / kLookMm)));
    for (int i = 1; i <= looks; ++i) {
      look(from_mm + (static_cast<double>(i) / looks) * (to_mm - from_mm), way_mm / looks,
           sample.time_ns);
    }
  }
  std::vector<StructureEntered> entered;
  for (const auto& [label, visit] : visits) entered.push_back(visit.so_far);
  return entered;
}

}  // namespace acus::training
