#include "acus/assess/dataset/sequence_maker.h"

#include "acus/assess/dataset/frame_moments.h"
#include "acus/assess/trials/trainee_session.h"
#include "acus/base/config/json_file.h"
#include "acus/base/config/shown_document.h"
#include "acus/run/replay/image_log.h"
#include "acus/run/replay/labelled_images.h"
#include "acus/run/replay/training_log.h"

namespace acus::dataset {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The scenario with the patient, the tools and the seed of the sequence.
scenario::Scenario ScenarioOf(const DatasetConfig& config, const SequencePlan& plan,
                              const fs::path& probe_file) {
  const DatasetPatient& patient = config.patients[plan.patient];
  std::vector<scenario::Override> changes;
  const auto set_path = [&changes](const char* pointer, const fs::path& path) {
    if (!path.empty()) changes.push_back({pointer, path.string()});
  };
  set_path("/patient/ct", patient.ct);
  set_path("/patient/labels", patient.labels);
  set_path("/patient/corridor", patient.corridor);
  set_path("/needle", plan.needle);
  const fs::path preset =
      plan.probe.empty() ? scenario::ReadScenario(plan.scenario, changes).probe : plan.probe;
  config::WriteJson(probe_file, ChangedProbe(preset, plan.probe_change));
  set_path("/probe", probe_file);
  const auto document = scenario::ScenarioDocument(plan.scenario, {});
  ACUS_REQUIRE(document.at("effects").contains("ultrasound"), plan.scenario.string(),
               ": /effects: has no ultrasound; a data set is made of its images");
  changes.push_back({"/effects/ultrasound/seed", plan.speckle_seed});
  set_path("/effects/ultrasound/display", plan.display);
  return scenario::ReadScenario(plan.scenario, changes);
}

trials::TrialScene LoadPatient(const scenario::Scenario& scenario, const fs::path& exercise_file,
                               RunContext& context) {
  const training::Exercise exercise = training::ReadExercise(exercise_file);
  context.provenance.AddInput(exercise_file);
  if (!scenario.patient.corridor.empty()) context.provenance.AddInput(scenario.patient.corridor);
  const auto plan = simulation::PlanEffects(scenario, {.needle_poses = true, .probe_poses = true});
  simulation::Scene scene = simulation::LoadScene(scenario, plan, context);
  replay::RequireAssessable(exercise, scenario, scene, nullptr);
  const auto target_ct_mm = replay::TargetInCtMm(exercise, scenario);
  return {scenario, std::move(scene), exercise, target_ct_mm};
}

std::vector<simulation::Snapshot> MomentsOf(const DatasetConfig& config,
                                            const trials::TrialScene& patient,
                                            const session::Session& session) {
  const auto inserted = [&patient](const session::PoseSample& sample) {
    return patient.IsInBody(patient.scene.ct_from_reference *
                            Eigen::Vector3d(sample.reference_from_tool.translation()));
  };
  std::vector<simulation::Snapshot> moments;
  for (const std::int64_t time_ns :
       FrameMoments(session.needle, inserted, config.frames_per_sequence, config.inserted_share)) {
    moments.push_back(replay::SnapshotAt(patient.scene, session, time_ns));
  }
  return moments;
}

json EntryOf(const DatasetConfig& config, const SequencePlan& plan, const std::string& split,
             const simulation::Scene& scene, const std::string& grade) {
  json entry = {{"sequence", plan.Name()},
                {"folder", "sequences/" + plan.Name()},
                {"patient", config.patients[plan.patient].id},
                {"split", split},
                {"scenario", plan.scenario.filename().string()},
                {"trainee", grade},
                {"motion_seed", plan.motion_seed},
                {"speckle_seed", plan.speckle_seed},
                {"probe", scene.probe->name},
                {"gain_db", scene.probe->gain_db},
                {"depth_mm", scene.probe->depth_mm},
                {"frequency_mhz", scene.probe->frequency_mhz},
                {"dynamic_range_db", scene.probe->dynamic_range_db},
                {"needle", scene.needle ? scene.needle->name : ""}};
  if (!plan.display.empty()) entry["display"] = plan.display.filename().string();
  return entry;
}

/// The scenario in the data set: its probe file is in the sequence's folder.
json ShownScenario(const scenario::Scenario& scenario) {
  json document = scenario.effective;
  document["probe"] = "probe.json";
  return config::ShownDocument(document);
}

}  // namespace

MadeSequence MakeSequence(const DatasetConfig& config, const SequencePlan& plan,
                          const std::string& split, replay::LabelFormat format,
                          const fs::path& folder, const RunContext& context) {
  MadeSequence made;
  RunContext quiet;
  quiet.stop = context.stop;
  quiet.on_warning = [&made](std::string_view text) { made.warnings.emplace_back(text); };
  fs::create_directories(folder);
  const scenario::Scenario scenario = ScenarioOf(config, plan, folder / "probe.json");
  const trials::TrialScene patient =
      LoadPatient(scenario, config.patients[plan.patient].exercise, quiet);
  const simulation::Scene& scene = patient.scene;
  const trials::TraineeSkill grade = trials::ReadTraineeSkill(plan.trainee);
  const auto trial = trials::SimulateTrial(patient, trials::PlannedPathOf(patient), grade,
                                           plan.Name(), 1, plan.motion_seed, config.step_rate_hz);
  auto moments = MomentsOf(config, patient, trial.session);
  const replay::StepLog steps =
      replay::RunSteps(scene, trial.session, moments, nullptr, quiet, nullptr);

  const auto source = replay::LabelSourceOf(scenario, scene, &patient.exercise, quiet);
  replay::LabelledImages images(scene, source, format, folder);
  simulation::ProbeImageRenderer renderer(scene, nullptr, simulation::ImageChoice::kBModeOnly);
  simulation::ProbeImages rendered;
  for (const simulation::Snapshot& moment : moments) {
    quiet.Checkpoint("images", 0.0);
    renderer.Render(moment, rendered);
    images.Write(moment, replay::StepAt(steps, moment.time_ns), rendered.b_mode);
  }
  made.entry = EntryOf(config, plan, split, scene, grade.grade);
  made.entry["frames"] = moments.size();
  made.entry["seconds"] = 1e-9 * static_cast<double>(trial.session.needle.back().time_ns);
  images.Finish({{"sequence", made.entry}, {"scenario", ShownScenario(scenario)}});
  made.classes = replay::ClassesOf(*source.labels);
  made.table = images.table();
  made.files = images.Files();
  made.input_sha256 = quiet.provenance.input_sha256;
  return made;
}

}  // namespace acus::dataset
