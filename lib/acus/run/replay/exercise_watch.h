// Follows an exercise step by step: goals with their values so far, the checklist.
#pragma once

#include <optional>
#include <vector>

#include "acus/run/replay/effect_meters.h"
#include "acus/run/replay/force_meter.h"
#include "acus/run/training/assessment.h"
#include "acus/run/training/exercise.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/simulation.h"

namespace acus::replay {

/// The area that the image of the scene's probe covers, at a depth; all zero without a probe.
training::ImageField FieldOf(const simulation::Scene& scene, std::optional<double> depth_mm);

/// A goal and its current state.
struct GoalNow {
  training::GoalResult result;
  bool at_end = false;  ///< Its metric is computed only from the whole session.
};

struct ExerciseProgress {
  std::vector<GoalNow> goals;
  std::vector<training::StepResult> checklist;
  double next_step_for_s = 0.0;  ///< How long the first open step has been open.
};

/// One thread at a time. A live session passes every step as it is recorded, a replay passes the
/// recording: both have the same bits as the report.
class ExerciseWatch {
 public:
  /// @param scene  Must have labels, and outlive this.
  ExerciseWatch(const training::Exercise& exercise, const simulation::Scene& scene,
                const std::optional<Eigen::Vector3d>& target_ct_mm);

  /// To be called before the step that carries out the command.
  void Obey(const session::Command& command);
  /// @param probe  Null: the session has none.
  void Add(const session::PoseSample& needle, const session::PoseSample* probe,
           const simulation::StepOutput& output);

  /// The metrics that goals may have: elapsed time and path of needle and probe, in tissue, of the
  /// target, of the forces and of effects; those of phases and smoothness are missing.
  std::vector<training::Metric> Metrics() const;
  ExerciseProgress progress() const;
  const std::vector<training::StepResult>& checklist() const { return checklist_.results(); }

 private:
  struct Path {
    std::optional<session::PoseSample> first, last;
    training::PathMeter path;
    void Add(const session::PoseSample& sample);
    void AddTo(std::vector<training::Metric>& metrics, const char* tool) const;
  };
  bool HasEnteredAvoided() const;

  training::Exercise exercise_;
  const simulation::Scene& scene_;
  training::SituationOptions situation_;
  training::LabelAtPoint label_at_;
  training::ImageField field_;
  std::vector<volume::Label> avoided_;
  Path needle_path_;
  Path probe_path_;
  training::TissueMeter tissue_;
  training::PassMeter passes_;
  training::PlaneMeter plane_;
  training::StructureMeter structures_;
  std::optional<training::TargetMeter> target_;
  ForceMeter forces_;
  EffectMeters effects_;
  training::ChecklistMeter checklist_;
  bool has_probe_ = false;
  bool breath_held_ = false;
  double plunger_n_ = 0.0;
  std::int64_t now_ns_ = 0;
  std::optional<std::size_t> next_step_;
  std::int64_t next_since_ns_ = 0;
};

/// The checklist of a recorded session.
std::vector<training::StepResult> ChecklistOf(const training::Exercise& exercise,
                                              const simulation::Scene& scene,
                                              const std::optional<Eigen::Vector3d>& target_ct_mm,
                                              const session::Session& session);

}  // namespace acus::replay
