#include "simulation/stage_timing.h"

namespace acus::simulation {

void StageTimes::Add(const StageTimes& other) {
  for (std::size_t i = 0; i < cost.size(); ++i) {
    cost[i].seconds += other.cost[i].seconds;
    cost[i].runs += other.cost[i].runs;
    cost[i].asleep += other.cost[i].asleep;
  }
}

void Stopwatch::EndOf(StageId id, bool asleep) noexcept {
  if (times_ == nullptr) return;
  const auto now = std::chrono::steady_clock::now();
  StageTimes::Cost& cost = times_->Of(id);
  cost.seconds += std::chrono::duration<double>(now - last_).count();
  ++cost.runs;
  if (asleep) ++cost.asleep;
  last_ = now;
}

}  // namespace acus::simulation
