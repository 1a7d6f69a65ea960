#include "acus/run/replay/event_log.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/data/session/pose_csv.h"

namespace acus::replay {

namespace {

/// Those of effects in a step: of each count that rises.
void AddEffectEvents(const simulation::Scene& scene, const StepLog& log, std::size_t i,
                     const Eigen::Vector3d& tip_ct_mm, std::vector<LoggedEvent>& events) {
  const simulation::StepOutput& step = log.steps[i];
  const double before_n = i > 0 ? log.steps[i - 1].force.AxialN() : 0.0;
  for (const simulation::ListedEffect& effect : scene.listed.all()) {
    for (std::size_t n = 0; n < effect.columns.size(); ++n) {
      const std::string& name = effect.columns[n].event;
      if (name.empty()) continue;
      const std::size_t at = effect.first_column + n;
      const double before = i > 0 ? log.steps[i - 1].effect[at] : 0.0;
      if (!(step.effect[at] > before)) continue;
      events.push_back({.time_ns = step.time_ns,
                        .name = name,
                        .effect = effect.key,
                        .tissue = TissueName(scene, step.tissue_at_tip),
                        .depth_mm = step.force.depth_mm,
                        .force_axial_n = step.force.AxialN(),
                        .force_before_n = before_n,
                        .tip_ct_mm = tip_ct_mm});
    }
  }
}

}  // namespace

std::vector<LoggedEvent> EventsOf(const simulation::Scene& scene, const StepLog& log) {
  std::vector<LoggedEvent> events;
  auto passed = log.passed.begin();
  for (std::size_t i = 0; i < log.steps.size(); ++i) {
    const simulation::StepOutput& step = log.steps[i];
    const forces::NeedleForce& force = step.force;
    const bool is_bendable = scene.shape && scene.shape->bendable();
    const Eigen::Vector3d tip_ct_mm =
        is_bendable ? step.shape.tip_in_ct_mm : step.ct_from_needle.translation();
    if (passed != log.passed.end() && passed->step == i) {
      for (; passed != log.passed.end() && passed->step == i; ++passed) {
        const forces::PassedEvent& event = passed->event;
        events.push_back({.time_ns = step.time_ns,
                          .event = event.event,
                          .name = std::string(forces::NameOf(event.event)),
                          .tissue = TissueName(scene, event.tissue),
                          .depth_mm = event.depth_mm,
                          .force_axial_n = event.force_axial_n,
                          .force_before_n = event.force_before_n,
                          .tip_ct_mm = tip_ct_mm});
      }
    } else if (force.event != forces::NeedleEvent::kNone) {
      const forces::NeedleForce before = i > 0 ? log.steps[i - 1].force : forces::NeedleForce{};
      const bool left = force.event == forces::NeedleEvent::kWithdrawal && i > 0;
      events.push_back({.time_ns = step.time_ns,
                        .event = force.event,
                        .name = std::string(forces::NameOf(force.event)),
                        .tissue = TissueName(scene, step.tissue_at_tip),
                        .depth_mm = left ? before.depth_mm : force.depth_mm,
                        .force_axial_n = force.AxialN(),
                        .force_before_n = before.AxialN(),
                        .tip_ct_mm = tip_ct_mm});
    }
    AddEffectEvents(scene, log, i, tip_ct_mm, events);
  }
  return events;
}

void WriteEvents(const std::filesystem::path& path, const std::vector<LoggedEvent>& events) {
  std::ofstream out(path, std::ios::binary);
  out << "time_s,event,tissue,depth_mm,force_axial_n,force_before_n\n";
  for (const LoggedEvent& event : events) {
    out << session::SecondsText(event.time_ns) << ',' << event.name << ',' << event.tissue << ','
        << NumberText(event.depth_mm) << ',' << NumberText(event.force_axial_n) << ','
        << NumberText(event.force_before_n) << '\n';
  }
  out.close();
  ACUS_REQUIRE(out, path.string(), ": cannot be written; is the disk full?");
}

nlohmann::json EventsJson(const std::vector<LoggedEvent>& events) {
  nlohmann::json list = nlohmann::json::array();
  for (const LoggedEvent& event : events) {
    list.push_back({{"time_s", 1e-9 * static_cast<double>(event.time_ns)},
                    {"event", event.name},
                    {"tissue", event.tissue},
                    {"depth_mm", event.depth_mm},
                    {"force_axial_n", event.force_axial_n},
                    {"force_before_n", event.force_before_n}});
  }
  return list;
}

}  // namespace acus::replay
