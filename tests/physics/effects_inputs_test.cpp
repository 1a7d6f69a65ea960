// What effects read: all of it is declared, nothing else is loaded, nothing is skipped in silence.
#include <cstddef>
#include <dlfcn.h>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "support/effects_patient.h"
#include "support/effects_run.h"

namespace {
int num_factorisations = 0;
}

// The test's own, in place of the libraries': they count, and do as they are asked.
extern "C" int cholmod_l_factorize(void* matrix, void* factor, void* common) {
  using Function = int (*)(void*, void*, void*);
  static const auto real = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "cholmod_l_factorize"));
  ++num_factorisations;
  return real(matrix, factor, common);
}
extern "C" void dpotrf_(const char* triangle, const int* n, double* a, const int* lda, int* info) {
  using Function = void (*)(const char*, const int*, double*, const int*, int*);
  static const auto real = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "dpotrf_"));
  ++num_factorisations;
  real(triangle, n, a, lda, info);
}

namespace acus::simulation {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using scenario::Scenario;
using testing::HasSubstr;
using testing_support::EffectChoice;

constexpr AvailableInputs kAll{.needle_poses = true, .probe_poses = true, .breath = true};
constexpr const char* kNowhere = "/nowhere/at/all";

const testing_support::EffectsPatient& EffectsInputsPatient() {
  static const testing_support::EffectsPatient patient;
  return patient;
}

/// A file that a scenario names.
class NamedFile {
 public:
  NamedFile() = default;
  NamedFile(fs::path* path) : path_(path) {}
  NamedFile(nlohmann::json* text) : text_(text) {}
  bool empty() const { return path_ != nullptr && path_->empty(); }
  void Set(const fs::path& to) const { path_ != nullptr ? void(*path_ = to) : void(*text_ = to); }

 private:
  fs::path* path_ = nullptr;
  nlohmann::json* text_ = nullptr;
};

/// All of them, by their place.
std::map<std::string, NamedFile> FilesOf(Scenario& s) {
  std::map<std::string, NamedFile> files = {{"/patient/ct", &s.patient.ct},
                                            {"/patient/labels", &s.patient.labels},
                                            {"/patient/mesh", &s.patient.mesh},
                                            {"/patient/corridor", &s.patient.corridor},
                                            {"/needle", &s.needle},
                                            {"/probe", &s.probe}};
  if (s.needle_force) files["/effects/needle_force/table"] = &s.needle_force->table;
  if (s.shape) files["/effects/needle/elasticity"] = &s.shape->elasticity;
  if (s.probe_force) files["/effects/probe_force/table"] = &s.probe_force->table;
  if (s.tissue) files["/effects/tissue/elasticity"] = &s.tissue->elasticity;
  if (s.tissue) files["/effects/tissue/table"] = &s.tissue->table;
  if (s.breathing) files["/effects/breathing/motion"] = &s.breathing->motion;
  if (s.breathing) files["/effects/breathing/signal"] = &s.breathing->signal;
  if (s.ultrasound) files["/effects/ultrasound"] = &s.ultrasound->acoustics;
  for (effects::CalledEffect& other : s.listed) {
    for (const effects::PathSetting& path : other.effect->Paths()) {
      if (!other.settings.contains(path.key)) continue;
      files["/effects/" + std::string(other.effect->key()) + "/" + path.key] =
          &other.settings[path.key];
    }
  }
  return files;
}

/// Leaves only the files that the plan declares.
void HideUndeclared(const EffectPlan& plan, Scenario& s) {
  for (const auto& [where, file] : FilesOf(s)) {
    const bool declared = std::ranges::any_of(
        plan.inputs(), [&where](const PlannedInput& input) { return input.where == where; });
    if (!declared && !file.empty()) file.Set(kNowhere);
  }
}

void ExpectOnlyDeclaredData(const EffectPlan& plan, const Scene& scene) {
  EXPECT_EQ(scene.ct != nullptr, plan.Needs(effects::ports::kCt));
  EXPECT_EQ(scene.labels != nullptr, plan.Needs(effects::ports::kLabels));
  EXPECT_EQ(scene.needle.has_value(), plan.Needs(effects::ports::kNeedlePreset));
  EXPECT_EQ(scene.probe.has_value(), plan.Needs(effects::ports::kProbePreset));
  EXPECT_EQ(scene.breathing.has_value(), plan.Needs(effects::ports::kMotion));
  EXPECT_EQ(scene.tissue.has_value(), plan.Needs(effects::ports::kTissueElasticity));
  EXPECT_EQ(scene.b_mode.has_value(), plan.Needs(effects::ports::kAcoustics));
  EXPECT_EQ(scene.forces.has_value(),
            plan.Writes(effects::ports::kForce) &&
                plan.Reads(effects::ports::kForce, effects::ports::kForceTable));
  EXPECT_EQ(scene.shape.has_value(), plan.Writes(effects::ports::kShape));
  EXPECT_EQ(scene.probe_force.has_value(), plan.Writes(effects::ports::kProbeForce));
}

void RunAll(const Scene& scene) {
  testing_support::EffectsRun run(scene);
  testing_support::Outputs out;
  run.Steps(60, {}, &out);
  run.RenderImages(run.Now(), out);
}

TEST(EffectInputs, EveryEffectRunsWithNothingButWhatItsStagesDeclare) {
  for (const EffectChoice& choice : testing_support::AllEffectChoices()) {
    SCOPED_TRACE(choice.name);
    Scenario s = EffectsInputsPatient().With(choice.effects);
    const EffectPlan plan = PlanEffects(s, {.needle_poses = true, .probe_poses = true});
    if (choice.effect == "breathing") {
      EXPECT_FALSE(plan.Writes(effects::ports::kBreath));  // Nobody is there to be moved.
    }
    HideUndeclared(plan, s);
    RunContext context;
    const Scene scene = LoadScene(s, plan, context);
    ExpectOnlyDeclaredData(plan, scene);
    RunAll(scene);
  }
}

TEST(EffectInputs, EveryPairOfEffectsRunsWithNothingButWhatItsStagesDeclare) {
  const auto all = testing_support::AllEffectChoices();
  int pairs = 0;
  for (const EffectChoice& a : all) {
    for (const EffectChoice& b : all) {
      if (a.effect >= b.effect || !testing_support::Agree(a.effects, b.effects)) continue;
      json effects = a.effects;
      effects.update(b.effects);
      SCOPED_TRACE(a.name + " and " + b.name);
      Scenario s = EffectsInputsPatient().With(effects);
      const EffectPlan plan = PlanEffects(s, {.needle_poses = true, .probe_poses = true});
      HideUndeclared(plan, s);
      RunContext context;
      const Scene scene = LoadScene(s, plan, context);
      ExpectOnlyDeclaredData(plan, scene);
      testing_support::EffectsRun run(scene);
      run.Steps(40, {});
      ++pairs;
    }
  }
  EXPECT_GT(pairs, 200);
}

/// Without an image there would be nothing for it to change.
bool IsSeenOnly(const EffectChoice& choice) {
  return choice.effect == "breathing" || choice.effect == "pulsating_vessels" ||
         choice.effect == "peristalsis" || choice.name.starts_with("tissue displacement_functions");
}

bool IsReadFor(const EffectPlan& plan, effects::PortRef input, const std::string& effect) {
  return std::ranges::any_of(plan.stages(), [&](const PlannedStage& stage) {
    return stage.in && stage.Reads(input) &&
           std::ranges::find(stage.effects, effect) != stage.effects.end();
  });
}

/// Where there is no label map. All others that read labels cannot do without.
bool TissuesAreToldByTheCt(const EffectChoice& choice) {
  if (choice.effects.contains("tissue")) {
    return choice.effects.at("tissue").value("model", "") == "springs";
  }
  return choice.effect == "needle_force" || choice.effect == "needle" || choice.effect == "fluid";
}

TEST(EffectInputs, EveryMissingInputOfEveryEffectIsAnErrorThatNamesBoth) {
  int missing = 0;
  for (const EffectChoice& choice : testing_support::AllEffectChoices()) {
    json effects = choice.effects;
    if (IsSeenOnly(choice)) effects["ct_slice"] = json::object();
    const Scenario whole = EffectsInputsPatient().With(effects);
    AvailableInputs there = kAll;
    there.breath = false;
    const EffectPlan plan = PlanEffects(whole, there);
    for (const PlannedInput& input : plan.inputs()) {
      if (!IsReadFor(plan, input.port, choice.effect)) continue;  // The image's.
      if (input.port == effects::ports::kPlungerForce) continue;  // Zero without orders.
      SCOPED_TRACE(choice.name + " without " + std::string(input.port.name()));
      const std::string needs = "needs " + std::string(input.port.name());
      Scenario s = whole;
      ++missing;
      if (input.file.empty()) {
        AvailableInputs less = there;
        (input.port == effects::ports::kNeedlePoses ? less.needle_poses : less.probe_poses) = false;
        EXPECT_THAT([&] { PlanEffects(s, less); },
                    testing::ThrowsMessage<InputError>(
                        testing::AllOf(HasSubstr(needs), HasSubstr("effects/" + choice.effect))));
        continue;
      }
      FilesOf(s).at(input.where).Set(kNowhere);
      RunContext context;
      EXPECT_THAT(
          [&] { LoadScene(s, PlanEffects(s, there), context); },
          testing::ThrowsMessage<InputError>(testing::AllOf(
              HasSubstr(needs), HasSubstr(kNowhere), HasSubstr("effects/" + choice.effect))));
      if (!input.where.starts_with("/patient")) continue;
      FilesOf(s).at(input.where).Set({});
      if (input.port == effects::ports::kLabels && TissuesAreToldByTheCt(choice)) continue;
      EXPECT_THAT([&] { PlanEffects(s, there); }, testing::ThrowsMessage<InputError>(testing::AllOf(
                                                      HasSubstr(needs), HasSubstr("is not given"),
                                                      HasSubstr("effects/" + choice.effect))));
    }
  }
  EXPECT_GT(missing, 100);
}

TEST(EffectInputs, WhatIsDeclaredIsRead) {
  const fs::path rubbish = EffectsInputsPatient().folder() / "rubbish.json";
  WriteTextFile(rubbish, "{\"format\": \"rubbish/1\"}");
  for (const EffectChoice& choice : testing_support::AllEffectChoices()) {
    json effects = choice.effects;
    if (IsSeenOnly(choice)) effects["ct_slice"] = json::object();
    const Scenario whole = EffectsInputsPatient().With(effects);
    const EffectPlan plan = PlanEffects(whole, {.needle_poses = true, .probe_poses = true});
    for (const PlannedInput& input : plan.inputs()) {
      if (input.file.empty()) continue;
      SCOPED_TRACE(choice.name + ": " + std::string(input.port.name()));
      Scenario s = whole;
      FilesOf(s).at(input.where).Set(rubbish);
      RunContext context;
      EXPECT_THROW(
          LoadScene(s, PlanEffects(s, {.needle_poses = true, .probe_poses = true}), context),
          InputError);
    }
  }
}

TEST(EffectInputs, ForcesAloneLoadNoImageAndImagesAloneFactorNoMatrix) {
  const auto load = [](const json& effects) {
    Scenario s = EffectsInputsPatient().With(effects);
    const EffectPlan plan = PlanEffects(s, {.needle_poses = true, .probe_poses = true});
    HideUndeclared(plan, s);
    RunContext context;
    Scene scene = LoadScene(s, plan, context);
    RunAll(scene);
    return scene;
  };
  EffectsInputsPatient();  // To make him takes factorisations of its own.
  num_factorisations = 0;
  const Scene forces =
      load({{"needle_force", {{"model", "layered"}}}, {"needle", {{"model", "bendable"}}}});
  EXPECT_EQ(forces.ct, nullptr);
  EXPECT_FALSE(forces.probe.has_value());
  EXPECT_FALSE(forces.b_mode.has_value());
  EXPECT_FALSE(forces.tissue.has_value());
  const Scene images = load({{"ultrasound", {{"model", "beams"}}},
                             {"ct_slice", json::object()},
                             {"fluoroscopy", json::object()},
                             {"view_3d", {{"width_px", 48}, {"height_px", 36}}},
                             {"breathing", {{"motion", "surrogate"}}}});
  EXPECT_FALSE(images.tissue.has_value());
  EXPECT_FALSE(images.forces.has_value());
  EXPECT_EQ(images.hu, nullptr);
  EXPECT_EQ(num_factorisations, 0);
  // Where a level inverts a matrix, it is counted: the zero above could be otherwise.
  load({{"tissue", {{"model", "fe_2d"}, {"fe_2d", {{"spacing_mm", 5}, {"width_mm", 40}}}}}});
  EXPECT_GT(num_factorisations, 0);
}

}  // namespace
}  // namespace acus::simulation
