#include "replay/step_log.h"

#include <algorithm>
#include <fstream>
#include <limits>

#include "core/cpu_time.h"
#include "core/csv.h"
#include "session/pose_csv.h"
#include "volume/labels.h"

namespace acus::replay {
namespace {

/// Hands images the load and the needle's shape of their moment, as the steps pass it.
class ImageStates {
 public:
  ImageStates(const simulation::Scene& scene, const simulation::Simulation& simulation,
              std::span<simulation::Snapshot> images, StepLog& log)
      : simulation_(simulation),
        log_(log),
        loads_(scene.tools_deform_images),
        shapes_(scene.plan.Has(simulation::StageId::kNeedleShape)) {
    if (loads_ || shapes_) images_ = images;
  }

  /// To all images before `time_ns`: the state after the last step.
  void GiveBefore(std::int64_t time_ns) {
    while (!images_.empty() && images_.front().time_ns < time_ns) {
      if (!log_.steps.empty()) Give(images_.front());
      images_ = images_.subspan(1);
    }
  }

 private:
  void Give(simulation::Snapshot& image) {
    if (loads_ && simulation_.LoadOf(log_.final_state, log_.steps.back(), load_)) {
      log_.loads.push_back(load_);
      image.load = &log_.loads.back();
    }
    if (shapes_ && simulation_.ShapeOf(log_.final_state, shape_)) {
      log_.shapes.push_back(shape_);
      image.needle_shape = &log_.shapes.back();
    }
  }

  const simulation::Simulation& simulation_;
  StepLog& log_;
  bool loads_;
  bool shapes_;
  std::span<simulation::Snapshot> images_;
  tissue::TissueLoad load_;
  math::Polyline shape_;
};

/// Keeps the needle's shape at its largest deflection.
void KeepMostBent(const simulation::Simulation& simulation, StepLog& log) {
  const simulation::NeedleShape& shape = log.steps.back().shape;
  const double most_mm =
      log.most_bent.empty() ? 0.0 : log.steps[log.most_bent_step].shape.tip_deflection_mm;
  if (!shape.bent || shape.tip_deflection_mm <= most_mm) return;
  simulation.ShapeOf(log.final_state, log.most_bent);
  log.most_bent_step = log.steps.size() - 1;
}

}  // namespace

breathing::Breath BreathOf(const session::Session& session, std::int64_t time_ns) {
  if (session.breath.empty()) return {};
  const session::BreathSample sample = session::BreathAt(session.breath, time_ns);
  return {.cycle = sample.cycle, .level = sample.level, .level_per_s = sample.level_per_s};
}

StepLog RunSteps(const simulation::Scene& scene, const session::Session& session,
                 std::span<simulation::Snapshot> images, simulation::StageTimes* times,
                 const RunContext& context) {
  StepLog log;
  const bool has_needle = scene.plan.Has(simulation::StageId::kNeedlePose);
  const bool feels_probe = scene.plan.Has(simulation::StageId::kProbeForce);
  if (!has_needle && !feels_probe) return log;
  const simulation::Simulation simulation(scene);
  log.final_state = simulation.NewState(session.start_ns());
  ImageStates states(scene, simulation, images, log);
  const bool presses = scene.plan.Has(simulation::StageId::kTissueContact);
  const bool has_probe = (feels_probe || presses) && !session.probe.empty();
  // The needle's samples come at the rate of forces. Where nobody asks for it, the probe's count.
  const session::PoseStream& clock = has_needle ? session.needle : session.probe;
  const std::size_t count = clock.size();
  log.steps.reserve(count);
  const std::size_t piece = count / 50 + 1;
  const double begin_s = ThreadCpuSeconds();
  for (std::size_t i = 0; i < count; ++i) {
    if (i % piece == 0) {
      context.Checkpoint("forces", static_cast<double>(i) / static_cast<double>(count));
    }
    simulation::Sample sample;
    sample.time_ns = clock[i].time_ns;
    if (has_needle) {
      sample.reference_from_needle = clock[i].reference_from_tool;
      sample.needle_valid = clock[i].valid;
    }
    if (has_probe) {
      const session::PoseSample pose =
          has_needle ? session::PoseAt(session.probe, sample.time_ns) : clock[i];
      sample.reference_from_probe = pose.reference_from_tool;
      sample.probe_valid = pose.valid;
    }
    sample.breath = BreathOf(session, sample.time_ns);
    states.GiveBefore(sample.time_ns);
    log.steps.push_back(simulation.Step(log.final_state, sample, times));
    KeepMostBent(simulation, log);
  }
  states.GiveBefore(std::numeric_limits<std::int64_t>::max());
  log.cpu_s = ThreadCpuSeconds() - begin_s;
  return log;
}

std::string TissueName(const simulation::Scene& scene, volume::Label label) {
  if (label == 0) return "outside";
  std::string name;
  if (scene.labels) {
    const auto found = scene.labels->names.find(label);
    if (found != scene.labels->names.end()) name = found->second;
  } else {
    for (const auto& standard : volume::StandardLabels()) {
      if (standard.label == label) name = standard.name;
    }
  }
  if (name.empty()) return Message("label_", int{label});
  std::ranges::replace_if(
      name, [](char c) { return c == ',' || c == '\n' || c == '\r'; }, ' ');
  return name;  // Segments may be called anything; in a CSV they may not.
}

std::string EventWords(forces::NeedleEvent event) {
  std::string words(forces::NameOf(event));
  std::ranges::replace(words, '_', ' ');
  return words;
}

/// What a needle that bends adds: the torque on it about the hand's tip, how far its tip is off the
/// line along which the hub points, and where the tip is in CT space.
constexpr const char* kShapeColumns =
    "torque_x_n_mm,torque_y_n_mm,torque_z_n_mm,deflection_mm,tip_x_mm,tip_y_mm,tip_z_mm,";

void WriteForces(const std::filesystem::path& path, const StepLog& log,
                 const simulation::Scene& scene) {
  const bool bendable = scene.shape && scene.shape->bendable();
  std::ofstream out(path, std::ios::binary);
  out << "time_s,depth_mm,tissue,force_axial_n,puncture_n,cutting_n,friction_n,bone_n,lateral_n,"
         "force_x_n,force_y_n,force_z_n,"
      << (bendable ? kShapeColumns : "") << "event\n";
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
    if (bendable) {
      for (int i = 0; i < 3; ++i) add(f.torque_in_ct_n_mm[i]);
      add(step.shape.tip_deflection_mm);
      for (int i = 0; i < 3; ++i) add(step.shape.tip_in_ct_mm[i]);
    }
    row += ',';
    if (f.event != forces::NeedleEvent::kNone) row += forces::NameOf(f.event);
    out << row << '\n';
  }
  out.close();
  ACUS_REQUIRE(out, path.string(), ": cannot be written; is the disk full?");
}

void WriteProbeForces(const std::filesystem::path& path, const StepLog& log,
                      const simulation::Scene& scene) {
  std::ofstream out(path, std::ios::binary);
  out << "time_s,force_n,force_x_n,force_y_n,force_z_n,torque_x_n_mm,torque_y_n_mm,torque_z_n_mm,"
         "skin_mm,bone_mm,proxies,structure\n";
  std::string row;
  for (const simulation::StepOutput& step : log.steps) {
    const forces::ProbeForce& f = step.probe;
    row = session::SecondsText(step.time_ns);
    const auto add = [&row](double value) { row += ',' + NumberText(value); };
    add(f.force_in_ct_n.norm());
    for (int i = 0; i < 3; ++i) add(f.force_in_ct_n[i]);
    for (int i = 0; i < 3; ++i) add(f.torque_in_ct_n_mm[i]);
    add(f.skin_mm);
    add(f.bone_mm);
    row += ',' + std::to_string(f.num_on_skin) + ',';
    if (f.structure != 0) row += TissueName(scene, f.structure);
    out << row << '\n';
  }
  out.close();
  ACUS_REQUIRE(out, path.string(), ": cannot be written; is the disk full?");
}

}  // namespace acus::replay
