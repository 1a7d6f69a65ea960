// All metrics of a session that depend on its poses and the patient's labels.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "acus/run/training/exercise.h"
#include "acus/run/training/metric.h"
#include "acus/run/training/structures.h"

namespace acus::training {

/// The patient of a session, at rest.
struct Anatomy {
  const volume::LabelMap& labels;
  Eigen::Isometry3d ct_from_reference = Eigen::Isometry3d::Identity();
};

/// A tissue with its name in the map.
struct NamedStructure {
  std::string name;
  StructureEntered entered;
};

/// Motion of both tools: elapsed time, path length, largest speed.
std::vector<Metric> MotionMetricsOf(const session::Session& session);

/// Metrics of the needle in tissue: time, path, damage, attempts, passes, redirections; with a
/// probe, the shares of that time in which the image plane contains the tip and the shaft.
std::vector<Metric> NeedleMetricsOf(const session::Session& session, const Anatomy& anatomy,
                                    const PassOptions& passes = {}, const PlaneOptions& plane = {});

/// The same from meters. @param share  Nothing: there is no probe.
std::vector<Metric> NeedleMetrics(const TissueMetrics& tissue,
                                  const std::vector<NeedlePass>& passes,
                                  const std::optional<PlaneShare>& share);

/// The label at a point of the reference frame. @param anatomy  Its labels must outlive the result.
LabelAtPoint LabelsOf(const Anatomy& anatomy);

inline constexpr const char* kTimeToTarget = "time until the target was reached";

/// Distances of the tip to a target: closest, at the end (at the deepest point of the last pass; of
/// the stream, if there is no pass), and kTimeToTarget, until it was within the radius; omitted if
/// it never was.
std::vector<Metric> TargetMetricsOf(const session::Session& session, const Anatomy& anatomy,
                                    const Eigen::Vector3d& target_ct_mm, const Exercise& exercise);

/// TargetMetricsOf for samples as they arrive.
class TargetMeter {
 public:
  TargetMeter(const Eigen::Vector3d& target_mm, double radius_mm)
      : target_mm_(target_mm), radius_mm_(radius_mm) {}
  void Add(const session::PoseSample& needle);
  /// @param passes  Passes of the same samples. Empty before the first valid sample.
  std::vector<Metric> Metrics(const std::vector<NeedlePass>& passes) const;

 private:
  Eigen::Vector3d target_mm_;  ///< Reference frame.
  double radius_mm_;
  double closest_mm_ = std::numeric_limits<double>::infinity();
  double end_mm_ = 0.0;
  std::optional<std::int64_t> first_ns_;
  std::optional<double> reached_s_;
};

/// The structures on the path of the tip, with names.
std::vector<NamedStructure> NamedStructuresOf(const session::Session& session,
                                              const Anatomy& anatomy);

/// "entries into what is to be spared": the sum over all of `avoid`.
Metric EntriesInto(const std::vector<std::string>& avoid,
                   const std::vector<NamedStructure>& structures);

Metric EntriesMetric(int entries);

/// Names in `avoid` that this patient's map does not distinguish from other tissue: standard labels
/// that it does not name.
/// @throws InputError if a name is neither in the map nor a standard label; lists those of the map.
std::vector<std::string> NotInMap(const std::vector<std::string>& avoid,
                                  const volume::LabelMap& labels);

}  // namespace acus::training
