#include "replay/step_log.h"

#include <algorithm>
#include <fstream>

#include "core/cpu_time.h"
#include "core/csv.h"
#include "session/pose_csv.h"

namespace acus::replay {

StepLog RunSteps(const simulation::Scene& scene, const session::Session& session,
                 simulation::StageTimes* times, const RunContext& context) {
  StepLog log;
  if (!scene.plan.Has(simulation::StageId::kNeedlePose)) return log;
  const simulation::Simulation simulation(scene);
  const std::size_t count = session.needle.size();
  log.steps.reserve(count);
  const std::size_t piece = count / 50 + 1;
  const double begin_s = ThreadCpuSeconds();
  for (std::size_t i = 0; i < count; ++i) {
    if (i % piece == 0) {
      context.Checkpoint("forces", static_cast<double>(i) / static_cast<double>(count));
    }
    const session::PoseSample& sample = session.needle[i];
    log.steps.push_back(simulation.Step(
        log.final_state, {sample.time_ns, sample.reference_from_tool, sample.valid}, times));
  }
  log.cpu_s = ThreadCpuSeconds() - begin_s;
  return log;
}

std::string TissueName(const simulation::Scene& scene, volume::Label label) {
  if (!scene.labels) return "";
  if (label == 0) return "outside";
  const auto found = scene.labels->names.find(label);
  if (found == scene.labels->names.end()) return Message("label_", int{label});
  std::string name = found->second;
  std::ranges::replace_if(
      name, [](char c) { return c == ',' || c == '\n' || c == '\r'; }, ' ');
  return name;  // Segments may be called anything; in a CSV they may not.
}

std::string EventWords(forces::NeedleEvent event) {
  std::string words(forces::NameOf(event));
  std::ranges::replace(words, '_', ' ');
  return words;
}

void WriteForces(const std::filesystem::path& path, const StepLog& log,
                 const simulation::Scene& scene) {
  std::ofstream out(path, std::ios::binary);
  out << "time_s,depth_mm,tissue,force_axial_n,puncture_n,cutting_n,friction_n,bone_n,lateral_n,"
         "force_x_n,force_y_n,force_z_n,event\n";
  std::string row;
  for (const simulation::StepOutput& step : log.steps) {
    const forces::NeedleForce& f = step.force;
    row = session::SecondsText(step.time_ns);
    const auto add = [&row](double value) { row += ',' + NumberText(value); };
    add(f.depth_mm);
    row += ',' + TissueName(scene, step.tissue_at_tip);
    for (const double value :
         {f.AxialN(), f.puncture_n, f.cutting_n, f.friction_n, f.bone_n, f.lateral_n}) {
      add(value);
    }
    for (int i = 0; i < 3; ++i) add(f.force_in_ct_n[i]);
    row += ',';
    if (f.event != forces::NeedleEvent::kNone) row += forces::NameOf(f.event);
    out << row << '\n';
  }
  out.close();
  ACUS_REQUIRE(out, path.string(), ": cannot be written; is the disk full?");
}

}  // namespace acus::replay
