// What stages cost, for a replay that was asked to explain itself.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>

#include "simulation/effect_plan.h"

namespace acus::simulation {

/// Wall-clock time by stage. Only ever written by the stages: no model reads it.
struct StageTimes {
  struct Cost {
    double seconds = 0.0;
    std::int64_t runs = 0;
    std::int64_t asleep = 0;  ///< Times that the scene gave the stage nothing to do.
  };
  std::array<Cost, kNumStages> cost{};

  Cost& Of(StageId id) { return cost[static_cast<std::size_t>(id)]; }
  const Cost& Of(StageId id) const { return cost[static_cast<std::size_t>(id)]; }
  void Add(const StageTimes& other);
};

/// Adds the time since it was made, or since the last EndOf, to a stage - if there is anybody to
/// tell; otherwise it does not even read the clock.
class Stopwatch {
 public:
  explicit Stopwatch(StageTimes* times) noexcept : times_(times) {
    if (times_ != nullptr) last_ = std::chrono::steady_clock::now();
  }
  void EndOf(StageId id, bool asleep = false) noexcept;

 private:
  StageTimes* times_;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace acus::simulation
