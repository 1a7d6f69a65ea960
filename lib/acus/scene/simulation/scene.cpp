#include "acus/scene/simulation/scene.h"

#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/segmentation/surface_scene.h"
#include "acus/physics/forces/measured_forces.h"
#include "acus/physics/mechanics/elasticity_table.h"
#include "acus/scene/simulation/needle_line.h"
#include "acus/scene/simulation/probe_scene.h"
#include "acus/scene/simulation/tissue_scene.h"

namespace acus::simulation {

namespace {

forces::GuidanceKind GuidanceOf(scenario::GuidanceKind kind) {
  switch (kind) {
    case scenario::GuidanceKind::kOwn:
      return forces::GuidanceKind::kOwn;
    case scenario::GuidanceKind::kNone:
      return forces::GuidanceKind::kNone;
    case scenario::GuidanceKind::kVidal:
      return forces::GuidanceKind::kVidal;
    case scenario::GuidanceKind::kVirtualFixture:
      return forces::GuidanceKind::kVirtualFixture;
  }
  ACUS_ASSERT(false);
}

void LoadForces(const scenario::Scenario& scenario, const EffectPlan& plan, Scene& scene,
                RunContext& context) {
  forces::ForceTable table = forces::ReadForceTable(scenario.needle_force->table);
  if (const double nick_mm = scenario.needle_force->skin_nick_radius_mm; nick_mm > 0.0) {
    table.nick = {ReadNeedleLine(scenario.patient.corridor).entry_in_ct_mm, nick_mm};
    context.provenance.AddInput(scenario.patient.corridor);
  }
  const bool by_hu = scenario.needle_force->model == scenario::NeedleForceModelKind::kVidal;
  const bool looks_in_ct = plan.Reads(StageId::kTissueLookup, effects::ports::kCt);
  if ((by_hu || looks_in_ct) && !scene.hu) scene.hu = std::make_shared<forces::CtField>(*scene.ct);
  if (looks_in_ct) {
    context.Warn(
        "there is no label map: tissues are identified by the CT's HU, as the force table says");
    scene.hu_tissues = table.hu_tissues;
  }
  const forces::GuidanceKind guidance = GuidanceOf(scenario.needle_force->guidance);
  if (by_hu) {
    scene.forces.emplace(forces::VidalModel(table, *scene.needle, *scene.hu, guidance));
  } else if (scenario.needle_force->model == scenario::NeedleForceModelKind::kAlamilla) {
    scene.forces.emplace(forces::AlamillaModel(table, *scene.needle, guidance));
  } else if (scenario.needle_force->model == scenario::NeedleForceModelKind::kMeasured) {
    const scenario::NeedleForceEffect& effect = *scenario.needle_force;
    const auto measured = forces::ReadMeasuredForces(effect.measured);
    context.provenance.AddInput(effect.measured);
    scene.forces.emplace(forces::MeasuredModel(
        table, *scene.needle,
        effect.seed > 0 ? measured.Drawn(effect.seed) : measured.Law(effect.recording),
        measured.needle_diameter_mm, guidance));
  } else {
    scene.forces.emplace(forces::NeedleForceModel(table, *scene.needle, guidance));
  }
}

/// Labels of the map; without one, the tissues that HU tell apart, or all that can be deformed.
/// A map that is there for other stages' sake says nothing here.
std::bitset<256> TissuesOf(const Scene& scene, const mechanics::ElasticityTable& elasticity) {
  std::bitset<256> found;
  if (scene.plan.Reads(StageId::kNeedleShape, effects::ports::kLabels)) {
    for (const volume::Label label : scene.labels->voxels) found.set(label);
  } else if (scene.hu_tissues) {
    for (const auto& row : scene.hu_tissues->rows) found.set(row.tissue);
  } else {
    for (std::size_t i = 1; i < 256; ++i) {
      found.set(i, elasticity.tissue[i].youngs_modulus_mpa > 0.0);
    }
  }
  return found;
}

void LoadShape(const scenario::Scenario& scenario, Scene& scene, RunContext& context) {
  const scenario::NeedleEffect& effect = *scenario.shape;
  const forces::ForceTable table = scene.force_from_tissue
                                       ? forces::ReadForceTable(scenario.tissue->table)
                                             .ScaledTo(scene.needle->beam.outer_diameter_mm)
                                       : scene.forces->table();
  std::optional<mechanics::ElasticityTable> elasticity;
  std::bitset<256> tissues;
  if (effect.model == scenario::NeedleModelKind::kBendable) {
    elasticity = mechanics::ReadElasticityTable(effect.elasticity);
    context.provenance.AddInput(effect.elasticity);
    tissues = TissuesOf(scene, *elasticity);
  }
  const bool has_beam = scenario.needle_force->model == scenario::NeedleForceModelKind::kLayered ||
                        scenario.needle_force->model == scenario::NeedleForceModelKind::kMeasured;
  scene.shape.emplace(effect, *scene.needle, table, elasticity ? &*elasticity : nullptr, tissues,
                      has_beam);
}

/// Labels, and a CT of constant HU in each tissue, where the patient is a list of surfaces.
void LoadSurfaces(const scenario::Scenario& scenario, const EffectPlan& plan, Scene& scene,
                  RunContext& context) {
  if (!plan.Needs(effects::ports::kCt) && !plan.Needs(effects::ports::kLabels)) return;
  const segmentation::SurfaceScene list = segmentation::ReadSurfaceScene(scenario.patient.surfaces);
  auto labels = segmentation::LabelsOfSurfaces(list, context);
  if (plan.Needs(effects::ports::kCt)) {
    scene.ct = std::make_shared<volume::CtVolume>(segmentation::CtOfLabels(list, labels));
  }
  if (plan.Needs(effects::ports::kLabels)) {
    scene.labels = std::make_shared<volume::LabelMap>(std::move(labels));
  }
  context.provenance.AddInput(scenario.patient.surfaces);
  for (const auto& surface : list.surfaces) context.provenance.AddInput(surface.file);
}

/// What a scenario says of the lines goes before what the preset says.
void SetLines(const scenario::UltrasoundEffect& effect, acoustics::Probe& probe) {
  if (effect.scan_lines > 0) probe.scan_lines = effect.scan_lines;
  if (effect.samples_per_line > 0) probe.samples_per_line = effect.samples_per_line;
}

/// What effects of the list may read of the patient: shared, so that it stays where it is.
effects::PortValues DataOf(const Scene& scene) {
  effects::PortValues values;
  if (scene.ct) values.Set(effects::ports::kCt, scene.ct.get());
  if (scene.labels) values.Set(effects::ports::kLabels, scene.labels.get());
  return values;
}

}  // namespace

Scene LoadScene(const scenario::Scenario& scenario, const EffectPlan& plan, RunContext& context) {
  RequireFiles(plan, scenario);
  Scene scene;
  scene.plan = plan;
  scene.ct_from_reference = scenario.patient.ct_from_reference;
  const nlohmann::json::json_pointer transform("/patient/ct_from_reference_file");
  if (scenario.effective.contains(transform)) {
    context.provenance.AddInput(scenario.file.parent_path() /
                                scenario.effective.at(transform).get<std::string>());
  }
  scene.image_rate_hz = scenario.image_rate_hz;
  if (scenario.ct_slice) {
    scene.needle_in_ct_slice = scenario.ct_slice->needle;
    scene.ct_window = {scenario.ct_slice->centre_hu, scenario.ct_slice->width_hu};
  }
  scene.needle_in_b_mode = scenario.ultrasound && scenario.ultrasound->needle;
  if (plan.Has(StageId::kBreathing)) {
    context.Checkpoint("reading the motion", 0.0);
    scene.breathing.emplace(LoadBreathing(scenario, plan.breath_from_session(), context));
  }
  if (!scenario.patient.surfaces.empty()) {
    LoadSurfaces(scenario, plan, scene, context);
  } else if (plan.Needs(effects::ports::kCt)) {
    context.Checkpoint("reading the CT", 0.0);
    scene.ct = std::make_shared<volume::CtVolume>(
        volume::ReadCt(scenario.patient.ct, scenario.patient.dicom_series, context));
    context.provenance.AddInput(scenario.patient.ct);
  }
  if (plan.Needs(effects::ports::kLabels) && scenario.patient.surfaces.empty()) {
    scene.labels = std::make_shared<volume::LabelMap>(volume::ReadTissues(scenario.patient.labels));
    context.provenance.AddInput(scenario.patient.labels);
  }
  if (plan.Needs(effects::ports::kNeedlePreset)) {
    scene.needle = forces::ReadNeedle(scenario.needle);
    context.provenance.AddInput(scenario.needle);
  }
  scene.force_from_tissue = scenario.needle_force &&
                            scenario.needle_force->model == scenario::NeedleForceModelKind::kTissue;
  if (plan.Has(StageId::kNeedleForce) && !scene.force_from_tissue) {
    LoadForces(scenario, plan, scene, context);
    context.provenance.AddInput(scenario.needle_force->table);
  }
  if (plan.Has(StageId::kNeedleShape)) LoadShape(scenario, scene, context);
  if (plan.Needs(effects::ports::kProbePreset)) {
    scene.probe = acoustics::ReadProbe(scenario.probe);
    if (scenario.ultrasound) SetLines(*scenario.ultrasound, *scene.probe);
    context.provenance.AddInput(scenario.probe);
  }
  if (plan.Has(StageId::kProbeForce)) {
    LoadProbeForce(*scenario.probe_force, scene);
    if (!scene.probe_force_from_tissue) {
      context.provenance.AddInput(scenario.probe_force->table);
    }
  }
  if (plan.Has(StageId::kUltrasound)) {
    const bool by_labels = plan.Reads(StageId::kUltrasound, effects::ports::kLabels);
    scene.b_mode = ReadImageSettings(*scenario.ultrasound, *scene.probe,
                                     by_labels ? scene.labels.get() : nullptr);
    context.provenance.AddInput(scenario.ultrasound->acoustics);
    if (!scenario.ultrasound->display.empty()) {
      context.provenance.AddInput(scenario.ultrasound->display);
      // Screens say what the images have.
      *scene.probe = ultrasound::ProbeOfLook(*scene.probe, *DisplayOf(*scene.b_mode), 0);
    }
  }
  scene.tools_deform_images =
      plan.Has(StageId::kDeformation) && scenario.tissue && scenario.tissue->image;
  if (plan.Has(StageId::kTissueContact) || scene.tools_deform_images) {
    scene.tissue = LoadTissue(scenario,
                              {.labels = scene.labels,
                               .probe = scene.probe ? &*scene.probe : nullptr,
                               .shows_deformation = scene.tools_deform_images},
                              context);
    scene.pressed_by_probe = scene.tools_deform_images && scenario.tissue->pressed_by_probe &&
                             scene.probe && scene.labels;
    scene.warp_spacing_mm = scenario.tissue->warp_spacing_mm;
    scene.inverse_iterations = scenario.tissue->inverse_iterations;
  }
  if (!scenario.listed.empty()) {
    scene.listed = ListedEffects(scenario, plan, DataOf(scene), context);
  }
  return scene;
}

}  // namespace acus::simulation
