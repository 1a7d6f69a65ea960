#include "simulation/scene.h"

#include "simulation/tissue_scene.h"
#include "volume/volume_io.h"

namespace acus::simulation {

namespace {

void LoadForces(const scenario::Scenario& scenario, const EffectPlan& plan, Scene& scene,
                RunContext& context) {
  const forces::ForceTable table = forces::ReadForceTable(scenario.needle_force->table);
  const bool by_hu = scenario.needle_force->model == scenario::NeedleForceModelKind::kVidal;
  const bool looks_in_ct = plan.Has(StageId::kTissueLookup) && !scene.labels;
  if (by_hu || looks_in_ct) scene.hu = std::make_shared<forces::CtField>(*scene.ct);
  if (looks_in_ct) {
    context.Warn("there is no label map: tissues are told by the CT's HU, as the force table says");
    scene.hu_tissues = table.hu_tissues;
  }
  if (by_hu) {
    scene.forces.emplace(forces::VidalModel(table, *scene.needle, *scene.hu));
  } else if (scenario.needle_force->model == scenario::NeedleForceModelKind::kAlamilla) {
    scene.forces.emplace(forces::AlamillaModel(table, *scene.needle));
  } else {
    scene.forces.emplace(forces::NeedleForceModel(table, *scene.needle));
  }
}

}  // namespace

Scene LoadScene(const scenario::Scenario& scenario, const EffectPlan& plan, RunContext& context) {
  Scene scene;
  scene.plan = plan;
  scene.ct_from_reference = scenario.patient.ct_from_reference;
  scene.image_rate_hz = scenario.image_rate_hz;
  scene.needle_in_ct_slice = scenario.ct_slice && scenario.ct_slice->needle;
  scene.needle_in_b_mode = scenario.ultrasound && scenario.ultrasound->needle;
  if (plan.Needs("ct")) {
    context.Checkpoint("reading the CT", 0.0);
    scene.ct = std::make_shared<volume::CtVolume>(
        volume::ReadCt(scenario.patient.ct, scenario.patient.dicom_series, context));
    context.provenance.AddInput(scenario.patient.ct);
  }
  if (plan.Needs("labels")) {
    scene.labels = std::make_shared<volume::LabelMap>(volume::ReadTissues(scenario.patient.labels));
    context.provenance.AddInput(scenario.patient.labels);
  }
  if (plan.Needs("needle")) {
    scene.needle = forces::ReadNeedle(scenario.needle);
    context.provenance.AddInput(scenario.needle);
  }
  scene.force_from_tissue = scenario.needle_force &&
                            scenario.needle_force->model == scenario::NeedleForceModelKind::kTissue;
  if (plan.Has(StageId::kNeedleForce) && !scene.force_from_tissue) {
    LoadForces(scenario, plan, scene, context);
    context.provenance.AddInput(scenario.needle_force->table);
  }
  if (plan.Needs("probe")) {
    scene.probe = ultrasound::ReadProbe(scenario.probe);
    context.provenance.AddInput(scenario.probe);
  }
  if (plan.Has(StageId::kUltrasound)) {
    scene.b_mode = ultrasound::ReadBModeOptions(scenario.ultrasound->acoustics);
    context.provenance.AddInput(scenario.ultrasound->acoustics);
  }
  if (plan.Has(StageId::kTissueContact) || plan.Has(StageId::kDeformation)) {
    scene.tissue = LoadTissue(scenario,
                              {.labels = scene.labels,
                               .probe = scene.probe ? &*scene.probe : nullptr,
                               .shows_deformation = plan.Has(StageId::kDeformation)},
                              context);
    scene.warp_spacing_mm = scenario.tissue->warp_spacing_mm;
  }
  return scene;
}

}  // namespace acus::simulation
