// What happened to the needle: the events of a run, for its files and its report.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "acus/run/replay/step_log.h"

namespace acus::replay {

struct LoggedEvent {
  std::int64_t time_ns = 0;
  /// kNone: an event of an effect, which has a name only.
  forces::NeedleEvent event = forces::NeedleEvent::kNone;
  std::string name;              ///< "puncture", "loss_of_resistance".
  std::string_view effect = {};  ///< Key of the effect whose event it is; empty: of the needle.
  std::string tissue;            ///< At the tip.
  double depth_mm = 0.0;         ///< Along the path; in deformed tissue at a withdrawal, before it.
  double force_axial_n = 0.0;    ///< Then: after a puncture, when the force has fallen.
  double force_before_n = 0.0;   ///< Just before: at a puncture, what it took.
  Eigen::Vector3d tip_ct_mm = Eigen::Vector3d::Zero();  ///< CT space, at the end of that step.
};

/// In order of time: those of the needle, and those of effects of the list.
std::vector<LoggedEvent> EventsOf(const simulation::Scene& scene, const StepLog& log);

/// events.csv: time_s,event,tissue,depth_mm,force_axial_n,force_before_n; one row per event.
void WriteEvents(const std::filesystem::path& path, const std::vector<LoggedEvent>& events);

/// The same as an array of objects, for run.json.
nlohmann::json EventsJson(const std::vector<LoggedEvent>& events);

}  // namespace acus::replay
