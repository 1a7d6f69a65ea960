#include "acus/run/training/session_metrics.h"

#include <algorithm>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/data/volume/label_lookup.h"
#include "acus/data/volume/labels.h"

namespace acus::training {
namespace {

using session::PoseSample;

LabelAtPoint LabelsOf(const Anatomy& anatomy) {
  const Eigen::Affine3d index_from_reference =
      anatomy.labels.geometry.index_from_ct() * anatomy.ct_from_reference;
  return [&labels = anatomy.labels, index_from_reference](const Eigen::Vector3d& point_mm) {
    return volume::LabelAt(labels, index_from_reference, point_mm);
  };
}

InsideTissue InsideOf(const Anatomy& anatomy) {
  return [label_at = LabelsOf(anatomy)](const Eigen::Vector3d& point_mm) {
    return label_at(point_mm) != 0;
  };
}

}  // namespace

std::vector<Metric> MotionMetricsOf(const session::Session& session) {
  std::vector<Metric> metrics;
  const auto add = [&metrics](const std::string& tool, const session::PoseStream& stream) {
    if (stream.empty()) return;
    const MotionMetrics motion = ComputeMotionMetrics(stream);
    metrics.push_back({tool + " elapsed time", "s", motion.elapsed_time_s});
    metrics.push_back({tool + " path length", "mm", motion.path_length_mm});
    metrics.push_back({tool + " largest speed", "mm/s", motion.max_speed_mm_per_s});
  };
  add("needle", session.needle);
  add("probe", session.probe);
  return metrics;
}

std::vector<Metric> NeedleMetricsOf(const session::Session& session, const Anatomy& anatomy,
                                    const PassOptions& pass_options,
                                    const PlaneOptions& plane_options) {
  const InsideTissue inside = InsideOf(anatomy);
  MetricOptions options;
  options.withdrawal_mm = pass_options.withdrawal_mm;
  const TissueMetrics tissue = ComputeTissueMetrics(session.needle, inside, options);
  const auto passes = FindPasses(session.needle, inside, pass_options);
  const auto redirections = std::ranges::count_if(passes, &NeedlePass::redirected);
  std::vector<Metric> metrics = {{"needle time in tissue", "s", tissue.time_in_tissue_s},
                                 {"needle path in tissue", "mm", tissue.path_in_tissue_mm},
                                 {"tissue damage", "mm^2", tissue.tissue_damage_mm2},
                                 {"attempts", "", static_cast<double>(tissue.num_insertions)},
                                 {"passes", "", static_cast<double>(passes.size())},
                                 {"redirections", "", static_cast<double>(redirections)}};
  if (session.probe.empty()) return metrics;
  const PlaneShare share = ComputePlaneShare(session, inside, plane_options);
  metrics.push_back({"tip in the image plane", "%", share.tip_percent});
  metrics.push_back({"needle in the image plane", "%", share.needle_percent});
  return metrics;
}

std::vector<Metric> TargetMetricsOf(const session::Session& session, const Anatomy& anatomy,
                                    const Eigen::Vector3d& target_ct_mm, const Exercise& exercise) {
  const Eigen::Vector3d target_mm = anatomy.ct_from_reference.inverse() * target_ct_mm;
  double closest_mm = std::numeric_limits<double>::infinity();
  double end_mm = 0.0;
  std::optional<double> reached_s;
  const PoseSample* first = nullptr;
  for (const PoseSample& sample : session.needle) {
    if (!sample.valid) continue;
    if (first == nullptr) first = &sample;
    end_mm = (sample.reference_from_tool.translation() - target_mm).norm();
    closest_mm = std::min(closest_mm, end_mm);
    if (!reached_s && end_mm <= exercise.target_radius_mm) {
      reached_s = 1e-9 * static_cast<double>(sample.time_ns - first->time_ns);
    }
  }
  if (first == nullptr) return {};
  const auto passes = FindPasses(session.needle, InsideOf(anatomy), exercise.passes);
  if (!passes.empty()) end_mm = (passes.back().tip_mm - target_mm).norm();
  std::vector<Metric> metrics = {{"tip to target, closest", "mm", closest_mm},
                                 {"tip to target at the end", "mm", end_mm}};
  if (reached_s) metrics.push_back({kTimeToTarget, "s", *reached_s});
  return metrics;
}

std::vector<NamedStructure> NamedStructuresOf(const session::Session& session,
                                              const Anatomy& anatomy) {
  std::vector<NamedStructure> named;
  for (const StructureEntered& entered : StructuresEntered(session.needle, LabelsOf(anatomy))) {
    const auto name = anatomy.labels.names.find(entered.label);
    named.push_back(
        {name == anatomy.labels.names.end() ? Message("label ", entered.label) : name->second,
         entered});
  }
  return named;
}

Metric EntriesInto(const std::vector<std::string>& avoid,
                   const std::vector<NamedStructure>& structures) {
  int entries = 0;
  for (const NamedStructure& structure : structures) {
    const bool is_to_be_spared = std::ranges::find(avoid, structure.name) != avoid.end();
    if (is_to_be_spared) entries += structure.entered.num_entries;
  }
  return {"entries into what is to be spared", "", static_cast<double>(entries)};
}

std::vector<std::string> NotInMap(const std::vector<std::string>& avoid,
                                  const volume::LabelMap& labels) {
  std::vector<std::string> missing;
  for (const std::string& name : avoid) {
    const auto has_name = [&](const auto& entry) { return entry.second == name; };
    if (std::ranges::any_of(labels.names, has_name)) continue;
    std::string known;
    for (const auto& [label, known_name] : labels.names) {
      known += (known.empty() ? "" : ", ") + known_name;
    }
    ACUS_REQUIRE(
        volume::FindLabel(name).has_value(), "the exercise is to spare \"", name,
        "\", which is no standard label and not in the patient's label map; it has: ", known);
    missing.push_back(name);
  }
  return missing;
}

}  // namespace acus::training
