// The cost of stages and when they sleep, for the explanation of a replay or a live session.
#pragma once

#include <array>
#include <cstdint>
#include <ctime>
#include <string_view>
#include <vector>

#include "acus/scene/simulation/effect_plan.h"

namespace acus::simulation {

/// Why a stage has nothing to do. A sleeping stage gives the bits that it would give awake.
enum class Sleep {
  kAwake,
  kNeedleUnseen,
  kNeedleOutside,
  kUntouched,
  kProbeUnseen,
  kProbeOffSkin,
  kAtRest,
  kUndeformed,
  kNothingMoved,
  kNeedleOffPlane,
  kEffectIdle,
  kEnd,
};
inline constexpr int kNumSleeps = static_cast<int>(Sleep::kEnd);

/// "needle outside the tissue"; "awake" for kAwake.
std::string_view WordsOf(Sleep sleep);

/// CPU time and runs of the stages of a plan. Only ever written by the stages: no model reads it.
struct StageTimes {
  struct Cost {
    /// CPU time of all runs. For stages at every sample, a sixteenth of the runs is measured and
    /// scaled: reading the clock takes as long as some of these stages do.
    double seconds = 0.0;
    std::int64_t runs = 0;
    std::int64_t asleep = 0;                            ///< Runs with nothing to do, in total ...
    std::array<std::int64_t, kNumSleeps> asleep_for{};  ///< ... and for each reason.
  };
  std::vector<Cost> cost;  ///< By the number of the stage.

  StageTimes() = default;
  explicit StageTimes(const EffectPlan& plan) : cost(plan.stages().size()) {}

  Cost& Of(const PlannedStage& stage) { return cost[stage.number]; }
  const Cost& Of(const PlannedStage& stage) const { return cost[stage.number]; }
  /// @pre both are of the same plan.
  void Add(const StageTimes& other);
};

/// Adds the CPU time since its construction, or since the last EndOf, to a stage. Without `times`
/// it does not read the clock.
class Stopwatch {
 public:
  /// CPU time of the calling thread.
  explicit Stopwatch(StageTimes* times) noexcept : Stopwatch(times, 1, CLOCK_THREAD_CPUTIME_ID) {}

  /// For the `number`-th of many short runs: measures one in sixteen.
  static Stopwatch OfStep(StageTimes* times, std::int64_t number) noexcept {
    return {times, number % kMeasuredEvery == 0 ? kMeasuredEvery : 0, CLOCK_THREAD_CPUTIME_ID};
  }

  /// For work that `num_threads` share while the rest of the process waits.
  static Stopwatch OfThreads(StageTimes* times, int num_threads) noexcept {
    return {times, 1, num_threads > 1 ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_THREAD_CPUTIME_ID};
  }

  void EndOf(std::size_t stage, Sleep sleep = Sleep::kAwake) noexcept;

 private:
  static constexpr int kMeasuredEvery = 16;

  Stopwatch(StageTimes* times, int stands_for, clockid_t clock) noexcept;

  StageTimes* times_;
  int stands_for_;  ///< Number of runs that one measurement represents; 0: not measured.
  clockid_t clock_;
  double last_s_ = 0.0;
};

}  // namespace acus::simulation
