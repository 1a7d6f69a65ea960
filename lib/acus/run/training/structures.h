// Which tissues the tip of the needle went through.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "acus/data/session/session.h"
#include "acus/data/volume/volume.h"

namespace acus::training {

/// The label at a point of the session's reference frame (mm).
using LabelAtPoint = std::function<volume::Label(const Eigen::Vector3d& point_in_reference_mm)>;

struct StructureEntered {
  volume::Label label = 0;
  /// The tip went in; again only after it was kReentryMm away from where it left. A distance, not a
  /// path: tremor at a surface is no entry, at any rate of samples.
  int num_entries = 0;
  double path_mm = 0.0;  ///< Of the tip within it.
  std::int64_t first_ns = 0;
};

inline constexpr double kReentryMm = 1.0;

/// All labels but 0 that the tip was in, in order of label. The way between two samples is straight
/// and is looked at every 0.25 mm, so that a quick stab through a thin vessel is seen.
std::vector<StructureEntered> StructuresEntered(const session::PoseStream& needle,
                                                const LabelAtPoint& label_at,
                                                std::span<const std::int64_t> swaps_ns = {});

/// The same of samples as they come.
class StructureMeter {
 public:
  explicit StructureMeter(LabelAtPoint label_at) : label_at_(std::move(label_at)) {}

  /// Samples that are not valid are passed over.
  void Add(const session::PoseSample& sample);
  /// The needle has changed hands: its way to the next sample is not looked at.
  void Restart() { last_mm_.reset(); }
  std::vector<StructureEntered> entered() const;
  /// Entries so far, over all of these labels.
  int EntriesInto(std::span<const volume::Label> labels) const;

 private:
  struct Visit {
    StructureEntered so_far;
    Eigen::Vector3d left_mm = Eigen::Vector3d::Zero();         ///< Where the tip was last in it.
    double away_mm = std::numeric_limits<double>::infinity();  ///< The farthest from there since.
  };
  void Look(const Eigen::Vector3d& tip_mm, double step_mm, std::int64_t time_ns);

  LabelAtPoint label_at_;
  std::map<volume::Label, Visit> visits_;
  std::optional<Eigen::Vector3d> last_mm_;
};

}  // namespace acus::training
