#include "acus/run/live/core_statistics.h"

#include <nlohmann/json.hpp>

namespace acus::live {
namespace {

nlohmann::json OfTool(
    const std::array<CoreStatistics::Count, CoreStatistics::kNumVerdicts>& verdicts) {
  const auto of = [&verdicts](PoseVerdict verdict) {
    return verdicts[static_cast<std::size_t>(verdict)].load();
  };
  return {{"good", of(PoseVerdict::kGood)},
          {"not_seen", of(PoseVerdict::kNotSeen)},
          {"not_finite", of(PoseVerdict::kNotFinite)},
          {"jumped", of(PoseVerdict::kJumped)}};
}

}  // namespace

nlohmann::json CoreStatistics::ToJson() const {
  return {{"ticks", ticks.load()},
          {"steps", steps.load()},
          {"readings_not_later", time_back.load()},
          {"missed_by_computation", missed_by_computation.load()},
          {"missed_by_machine", missed_by_machine.load()},
          {"needle_readings", OfTool(needle)},
          {"probe_readings", OfTool(probe)},
          {"needle_chatter_n", needle_chatter_n.load()},
          {"step_cpu", step_cpu.ToJson()},
          {"device_to_force", device_to_force.ToJson()},
          {"interval", interval.ToJson()}};
}

}  // namespace acus::live
