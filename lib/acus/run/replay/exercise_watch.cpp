#include "acus/run/replay/exercise_watch.h"

#include <algorithm>
#include <cmath>

#include "acus/imaging/acoustics/probe.h"
#include "acus/run/training/session_metrics.h"

namespace acus::replay {
namespace {

using session::PoseSample;
using training::Metric;

training::InsideTissue InsideBy(const training::LabelAtPoint& label_at) {
  return [label_at](const Eigen::Vector3d& point_mm) { return label_at(point_mm) != 0; };
}

training::MetricOptions MetricOptionsOf(const training::Exercise& exercise) {
  training::MetricOptions options;
  options.withdrawal_mm = exercise.passes.withdrawal_mm;
  return options;
}

}  // namespace

training::ImageField FieldOf(const simulation::Scene& scene, std::optional<double> depth_mm) {
  training::ImageField field;
  if (!scene.probe) return field;
  const acoustics::Probe& probe = *scene.probe;
  field.depth_mm = depth_mm.value_or(probe.depth_mm);
  field.half_width_mm = 0.5 * probe.width_mm;
  if (probe.kind != acoustics::ProbeKind::kLinear) {
    field.radius_mm = probe.radius_mm;
    field.half_angle_rad = 0.5 * probe.field_of_view_rad;
  }
  return field;
}

void ExerciseWatch::Path::Add(const PoseSample& sample) {
  if (!sample.valid) return;
  if (!first) first = sample;
  last = sample;
  path.Add(sample);
}

void ExerciseWatch::Path::AddTo(std::vector<Metric>& metrics, const char* tool) const {
  const double elapsed_s = first ? 1e-9 * static_cast<double>(last->time_ns - first->time_ns) : 0.0;
  metrics.push_back({std::string(tool) + " elapsed time", "s", elapsed_s});
  metrics.push_back({std::string(tool) + " path length", "mm", path.length_mm()});
}

ExerciseWatch::ExerciseWatch(const training::Exercise& exercise, const simulation::Scene& scene,
                             const std::optional<Eigen::Vector3d>& target_ct_mm)
    : exercise_(exercise),
      scene_(scene),
      label_at_(training::LabelsOf({*scene.labels, scene.ct_from_reference})),
      field_(FieldOf(scene, {})),
      tissue_(InsideBy(label_at_), MetricOptionsOf(exercise)),
      passes_(InsideBy(label_at_), exercise.passes),
      plane_(InsideBy(label_at_), exercise.image_plane),
      structures_(label_at_),
      effects_(scene),
      checklist_(exercise.checklist) {
  situation_.plane = exercise.image_plane;
  situation_.target_radius_mm = exercise.target_radius_mm;
  if (target_ct_mm) {
    situation_.target_mm = scene.ct_from_reference.inverse() * *target_ct_mm;
    target_.emplace(*situation_.target_mm, exercise.target_radius_mm);
  }
  for (const auto& [label, name] : scene.labels->names) {
    if (std::ranges::find(exercise.avoid, name) != exercise.avoid.end()) avoided_.push_back(label);
  }
}

void ExerciseWatch::Obey(const session::Command& command) {
  using session::CommandKind;
  if (command.kind == CommandKind::kDepth) field_ = FieldOf(scene_, command.value);
  if (command.kind == CommandKind::kHoldBreath) breath_held_ = true;
  if (command.kind == CommandKind::kBreatheOn) breath_held_ = false;
  if (command.kind == CommandKind::kPlunger) plunger_n_ = command.value;
  if (command.kind != CommandKind::kSwapHands) return;
  needle_path_.path.Restart();
  probe_path_.path.Restart();
  tissue_.Restart();
  passes_.Restart();
  structures_.Restart();
}

bool ExerciseWatch::HasEnteredAvoided() const {
  return structures_.EntriesInto(avoided_) > 0;
}

void ExerciseWatch::Add(const PoseSample& needle, const PoseSample* probe,
                        const simulation::StepOutput& output) {
  now_ns_ = needle.time_ns;
  has_probe_ = probe != nullptr;
  needle_path_.Add(needle);
  tissue_.Add(needle);
  passes_.Add(needle);
  structures_.Add(needle);
  if (target_) target_->Add(needle);
  if (has_probe_) {
    probe_path_.Add(*probe);
    plane_.Add(needle, *probe);
  }
  forces_.Add(output);
  effects_.Add(output);
  training::Situation now = SituationOf(needle, probe, field_, label_at_, situation_);
  now.breath_held = breath_held_;
  now.plunger_n = plunger_n_;
  checklist_.Add(now_ns_, now, HasEnteredAvoided());
  const auto next = training::NextStep(checklist_.results());
  if (next != next_step_ || next_since_ns_ == 0) next_since_ns_ = now_ns_;
  next_step_ = next;
}

std::vector<Metric> ExerciseWatch::Metrics() const {
  std::vector<Metric> metrics;
  needle_path_.AddTo(metrics, "needle");
  if (has_probe_) probe_path_.AddTo(metrics, "probe");
  const auto add = [&metrics](const std::vector<Metric>& more) {
    metrics.insert(metrics.end(), more.begin(), more.end());
  };
  const auto passes = passes_.passes();
  std::optional<training::PlaneShare> share;
  if (has_probe_) share = plane_.share();
  add(training::NeedleMetrics(tissue_.metrics(), passes, share));
  add(forces_.Metrics(scene_));
  add(effects_.Metrics());
  if (target_) add(target_->Metrics(passes));
  metrics.push_back(training::EntriesMetric(structures_.EntriesInto(avoided_)));
  return metrics;
}

ExerciseProgress ExerciseWatch::progress() const {
  ExerciseProgress progress;
  const std::vector<Metric> metrics = Metrics();
  for (const training::Goal& goal : exercise_.goals) {
    const bool is_there = std::ranges::find(metrics, goal.metric, &Metric::name) != metrics.end() ||
                          (target_ && goal.metric == training::kTimeToTarget);
    if (is_there && needle_path_.first) {
      progress.goals.push_back({.result = training::JudgeGoals({goal}, metrics).front()});
    } else {
      progress.goals.push_back({.result = {.goal = goal, .unit = {}, .value = {}}, .at_end = true});
    }
  }
  progress.checklist = checklist_.results();
  if (next_since_ns_ != 0) {
    progress.next_step_for_s = 1e-9 * static_cast<double>(now_ns_ - next_since_ns_);
  }
  return progress;
}

std::vector<training::StepResult> ChecklistOf(const training::Exercise& exercise,
                                              const simulation::Scene& scene,
                                              const std::optional<Eigen::Vector3d>& target_ct_mm,
                                              const session::Session& session) {
  ExerciseWatch watch(exercise, scene, target_ct_mm);
  std::span<const session::Command> commands(session.commands);
  for (const PoseSample& needle : session.needle) {
    for (; !commands.empty() && commands.front().time_ns <= needle.time_ns;
         commands = commands.subspan(1)) {
      watch.Obey(commands.front());
    }
    if (session.probe.empty()) {
      watch.Add(needle, nullptr, {});
    } else {
      const PoseSample probe = session::PoseAt(session.probe, needle.time_ns);
      watch.Add(needle, &probe, {});
    }
  }
  return watch.checklist();
}

}  // namespace acus::replay
