// The tissues on the path of the needle's tip.
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
#include "acus/run/training/motion_metrics.h"

namespace acus::training {

/// The label at a point of the session's reference frame (mm).
using LabelAtPoint = std::function<volume::Label(const Eigen::Vector3d& point_in_reference_mm)>;

struct StructureEntered {
  volume::Label label = 0;
  /// Entries of the tip; another one counts only after the tip was kReentryMm away from its exit. A
  /// distance, not a path length: tremor at a surface is no entry, at any sampling rate.
  int num_entries = 0;
  /// Path length of the tip within it, over the samples of PathPacer, as the path in tissue: tremor
  /// does not make it grow with the sampling rate.
  double path_mm = 0.0;
  std::int64_t first_ns = 0;
};

inline constexpr double kReentryMm = 1.0;

/// All labels except 0 that the tip was in, in order of label. The line between two samples is
/// straight and is sampled every 0.25 mm, so that a quick stab through a thin vessel is found.
std::vector<StructureEntered> StructuresEntered(const session::PoseStream& needle,
                                                const LabelAtPoint& label_at,
                                                std::span<const std::int64_t> swaps_ns = {});

/// StructuresEntered for samples as they arrive.
class StructureMeter {
 public:
  explicit StructureMeter(LabelAtPoint label_at) : label_at_(std::move(label_at)) {}

  /// Samples that are not valid are ignored.
  void Add(const session::PoseSample& sample);
  /// The needle has changed hands: the path to the next sample is ignored.
  void Restart();
  std::vector<StructureEntered> entered() const;
  /// Entries so far, the sum over all of these labels.
  int EntriesInto(std::span<const volume::Label> labels) const;

 private:
  struct Visit {
    StructureEntered so_far;
    Eigen::Vector3d left_mm = Eigen::Vector3d::Zero();         ///< Last tip position in it.
    double away_mm = std::numeric_limits<double>::infinity();  ///< Largest distance since.
  };
  void Look(const Eigen::Vector3d& tip_mm, std::int64_t time_ns);
  void AddPathTo(std::map<volume::Label, Visit>& visits) const;

  LabelAtPoint label_at_;
  std::map<volume::Label, Visit> visits_;
  std::optional<Eigen::Vector3d> last_mm_;
  PathPacer pacer_;
  std::optional<Eigen::Vector3d> taken_mm_;
};

}  // namespace acus::training
