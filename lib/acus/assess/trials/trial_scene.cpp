#include "acus/assess/trials/trial_scene.h"

#include <bit>

#include "acus/data/volume/label_lookup.h"
#include "acus/run/replay/run_metrics.h"
#include "acus/run/replay/training_log.h"

namespace acus::trials {
namespace {

class Fnv1a {
 public:
  void Add(std::uint64_t bits) {
    for (int byte = 0; byte < 8; ++byte) {
      hash_ = (hash_ ^ ((bits >> (8 * byte)) & 0xffU)) * 0x100000001b3ULL;
    }
  }
  void Add(double value) { Add(std::bit_cast<std::uint64_t>(value)); }
  std::uint64_t hash() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

simulation::Scene LoadedScene(const scenario::Scenario& scenario, const session::Session& like,
                              RunContext& context) {
  const auto plan = simulation::PlanEffects(
      scenario,
      {.needle_poses = true, .probe_poses = !like.probe.empty(), .breath = !like.breath.empty()});
  return simulation::LoadScene(scenario, plan, context);
}

scenario::Scenario WithoutImages(scenario::Scenario scenario) {
  scenario.ultrasound.reset();
  scenario.ct_slice.reset();
  return scenario;
}

/// Without the data of images, if the label map is read for steps.
simulation::Scene SceneForSteps(const scenario::Scenario& scenario, const session::Session& like,
                                RunContext& context) {
  if (scenario.needle_force || scenario.probe_force || scenario.tissue) {
    simulation::Scene scene = LoadedScene(WithoutImages(scenario), like, context);
    if (scene.labels) return scene;
  }
  return LoadedScene(scenario, like, context);
}

}  // namespace

bool TrialScene::IsInBody(const Eigen::Vector3d& point_ct_mm) const {
  return volume::LabelAt(*scene.labels, scene.labels->geometry.index_from_ct(), point_ct_mm) != 0;
}

TrialScene LoadTrialScene(const scenario::Scenario& scenario, const std::filesystem::path& exercise,
                          const session::Session& like, RunContext& context) {
  const training::Exercise read = training::ReadExercise(exercise);
  context.provenance.AddInput(exercise);
  simulation::Scene scene = SceneForSteps(scenario, like, context);
  replay::RequireAssessable(read, scenario, scene, nullptr);
  for (const std::string& name : training::NotInMap(read.avoid, *scene.labels)) {
    context.Warn(
        Message("the patient's label map has no ", name, ": entries into it are not counted"));
  }
  const auto target_ct_mm = replay::TargetInCtMm(read, scenario);
  return {scenario, std::move(scene), read, target_ct_mm};
}

std::uint64_t ForceHash(const replay::StepLog& steps) {
  Fnv1a hash;
  for (const simulation::StepOutput& step : steps.steps) {
    hash.Add(static_cast<std::uint64_t>(step.time_ns));
    hash.Add(step.force.depth_mm);
    for (const Eigen::Vector3d& force : {step.force.force_in_ct_n, step.probe.force_in_ct_n}) {
      for (int axis = 0; axis < 3; ++axis) hash.Add(force[axis]);
    }
  }
  return hash.hash();
}

TrialResult RunTrial(const TrialScene& scene, const session::Session& session,
                     const RunContext& context) {
  RunContext quiet;
  quiet.stop = context.stop;
  const replay::StepLog steps = replay::RunSteps(scene.scene, session, {}, nullptr, quiet, nullptr);
  auto metrics = replay::MetricsOf(scene.scene, session, steps, &scene.exercise);
  return {replay::AssessMotion(scene.exercise, scene.anatomy(), scene.target_ct_mm, session,
                               std::move(metrics)),
          replay::EventsOf(scene.scene, steps), ForceHash(steps), steps.cpu_s};
}

}  // namespace acus::trials
