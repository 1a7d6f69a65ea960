#include "acus/run/training/session_metrics.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/data/volume/label_lookup.h"
#include "acus/data/volume/labels.h"

namespace acus::training {
namespace {

using session::PoseSample;

InsideTissue InsideOf(const Anatomy& anatomy) {
  return [label_at = LabelsOf(anatomy)](const Eigen::Vector3d& point_mm) {
    return label_at(point_mm) != 0;
  };
}

}  // namespace

LabelAtPoint LabelsOf(const Anatomy& anatomy) {
  const Eigen::Affine3d index_from_reference =
      anatomy.labels.geometry.index_from_ct() * anatomy.ct_from_reference;
  return [&labels = anatomy.labels, index_from_reference](const Eigen::Vector3d& point_mm) {
    return volume::LabelAt(labels, index_from_reference, point_mm);
  };
}

std::vector<Metric> MotionMetricsOf(const session::Session& session) {
  std::vector<Metric> metrics;
  const std::vector<std::int64_t> swaps_ns = SwapTimesNs(session);
  const auto add = [&](const std::string& tool, const session::PoseStream& stream) {
    if (stream.empty()) return;
    const MotionMetrics motion = ComputeMotionMetrics(stream, {}, swaps_ns);
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
  const auto swaps_ns = SwapTimesNs(session);
  const TissueMetrics tissue = ComputeTissueMetrics(session.needle, inside, options, swaps_ns);
  const auto passes = FindPasses(session.needle, inside, pass_options, swaps_ns);
  if (session.probe.empty()) return NeedleMetrics(tissue, passes, {});
  return NeedleMetrics(tissue, passes, ComputePlaneShare(session, inside, plane_options));
}

std::vector<Metric> NeedleMetrics(const TissueMetrics& tissue,
                                  const std::vector<NeedlePass>& passes,
                                  const std::optional<PlaneShare>& share) {
  const auto redirections = std::ranges::count_if(passes, &NeedlePass::redirected);
  std::vector<Metric> metrics = {{"needle time in tissue", "s", tissue.time_in_tissue_s},
                                 {"needle path in tissue", "mm", tissue.path_in_tissue_mm},
                                 {"tissue damage", "mm^2", tissue.tissue_damage_mm2},
                                 {"attempts", "", static_cast<double>(tissue.num_insertions)},
                                 {"passes", "", static_cast<double>(passes.size())},
                                 {"redirections", "", static_cast<double>(redirections)}};
  if (!share) return metrics;
  metrics.push_back({"tip in the image plane", "%", share->tip_percent});
  metrics.push_back({"needle in the image plane", "%", share->needle_percent});
  return metrics;
}

void TargetMeter::Add(const PoseSample& needle) {
  if (!needle.valid) return;
  if (!first_ns_) first_ns_ = needle.time_ns;
  end_mm_ = (needle.reference_from_tool.translation() - target_mm_).norm();
  closest_mm_ = std::min(closest_mm_, end_mm_);
  if (!reached_s_ && end_mm_ <= radius_mm_) {
    reached_s_ = 1e-9 * static_cast<double>(needle.time_ns - *first_ns_);
  }
}

std::vector<Metric> TargetMeter::Metrics(const std::vector<NeedlePass>& passes) const {
  if (!first_ns_) return {};
  const double end_mm = passes.empty() ? end_mm_ : (passes.back().tip_mm - target_mm_).norm();
  std::vector<Metric> metrics = {{"tip to target, closest", "mm", closest_mm_},
                                 {"tip to target at the end", "mm", end_mm}};
  if (reached_s_) metrics.push_back({kTimeToTarget, "s", *reached_s_});
  return metrics;
}

std::vector<Metric> TargetMetricsOf(const session::Session& session, const Anatomy& anatomy,
                                    const Eigen::Vector3d& target_ct_mm, const Exercise& exercise) {
  TargetMeter meter(anatomy.ct_from_reference.inverse() * target_ct_mm, exercise.target_radius_mm);
  for (const PoseSample& sample : session.needle) meter.Add(sample);
  return meter.Metrics(
      FindPasses(session.needle, InsideOf(anatomy), exercise.passes, SwapTimesNs(session)));
}

std::vector<NamedStructure> NamedStructuresOf(const session::Session& session,
                                              const Anatomy& anatomy) {
  std::vector<NamedStructure> named;
  for (const StructureEntered& entered :
       StructuresEntered(session.needle, LabelsOf(anatomy), SwapTimesNs(session))) {
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
  return EntriesMetric(entries);
}

Metric EntriesMetric(int entries) {
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
