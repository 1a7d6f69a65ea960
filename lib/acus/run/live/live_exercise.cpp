#include "acus/run/live/live_exercise.h"

#include <utility>

namespace acus::live {

void LiveExercise::Add(const StepRecord& record) {
  for (int i = 0; i < record.num_commands; ++i) {
    watch_.Obey(record.command[static_cast<std::size_t>(i)]);
  }
  watch_.Add(record.needle, has_probe_ ? &record.probe : nullptr, record.output);
}

void LiveExercise::Publish() {
  replay::ExerciseProgress progress = watch_.progress();
  const std::lock_guard lock(mutex_);
  progress_ = std::move(progress);
}

replay::ExerciseProgress LiveExercise::progress() const {
  const std::lock_guard lock(mutex_);
  return progress_;
}

}  // namespace acus::live
