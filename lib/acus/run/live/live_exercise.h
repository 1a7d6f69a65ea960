// The exercise of a live session: updated by the recorder's thread, read by the window's.
#pragma once

#include <Eigen/Core>
#include <mutex>
#include <optional>

#include "acus/run/live/step_record.h"
#include "acus/run/replay/exercise_watch.h"

namespace acus::live {

class LiveExercise {
 public:
  /// @param scene  Must have labels, and outlive this.
  LiveExercise(const training::Exercise& exercise, const simulation::Scene& scene,
               const std::optional<Eigen::Vector3d>& target_ct_mm, bool has_probe)
      : exercise_(exercise),
        target_in_ct_mm_(target_ct_mm),
        has_probe_(has_probe),
        watch_(exercise, scene, target_ct_mm) {}

  /// One thread: each step in order, then Publish().
  void Add(const StepRecord& record);
  void Publish();

  /// Any thread: the state at the last Publish().
  replay::ExerciseProgress progress() const;
  const training::Exercise& exercise() const { return exercise_; }
  const std::optional<Eigen::Vector3d>& target_in_ct_mm() const { return target_in_ct_mm_; }

 private:
  training::Exercise exercise_;
  std::optional<Eigen::Vector3d> target_in_ct_mm_;
  bool has_probe_;
  replay::ExerciseWatch watch_;
  mutable std::mutex mutex_;
  replay::ExerciseProgress progress_;
};

}  // namespace acus::live
