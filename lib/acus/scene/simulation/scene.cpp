#include "acus/scene/simulation/scene.h"

#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "acus/base/core/words.h"
#include "acus/data/volume/labels_of_ct.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/segmentation/quality_parts.h"
#include "acus/patient/segmentation/surfaces/surface_scene.h"
#include "acus/scene/simulation/coupled/coupled_effect.h"

namespace acus::simulation {

namespace {

/// The surfaces for ray tracing, in the order in which their voxels are filled.
std::shared_ptr<const tracing::SurfaceTracer> TrianglesOf(
    const segmentation::SurfaceScene& list, std::vector<segmentation::ClosedSurface> surfaces,
    int num_threads) {
  std::vector<tracing::LabelledSurface> labelled;
  for (const std::size_t n : segmentation::RisingOrder(list)) {
    labelled.push_back(
        {std::move(surfaces[n].surface), surfaces[n].winding, list.surfaces[n].label});
  }
  return std::make_shared<tracing::SurfaceTracer>(std::move(labelled), num_threads);
}

/// Labels, and a CT of constant HU in each tissue, where the patient is a list of surfaces.
void LoadSurfaces(const scenario::Scenario& scenario, const EffectPlan& plan, Scene& scene,
                  RunContext& context) {
  if (!plan.Needs(effects::ports::kCt) && !plan.Needs(effects::ports::kLabels)) return;
  const segmentation::SurfaceScene list = segmentation::ReadSurfaceScene(scenario.patient.surfaces);
  auto surfaces = segmentation::ReadClosedSurfaces(list, context);
  auto labels = segmentation::LabelsOfSurfaces(list, surfaces, context);
  if (plan.Needs(effects::ports::kCt)) {
    scene.ct = std::make_shared<volume::CtVolume>(segmentation::CtOfLabels(list, labels));
  }
  if (plan.Needs(effects::ports::kLabels)) {
    scene.labels = std::make_shared<volume::LabelMap>(std::move(labels));
  }
  if (plan.Writes(effects::ports::kBMode) && scenario.ultrasound->from_triangles) {
    context.Checkpoint("arranging triangles", 0.0);
    scene.triangles = TrianglesOf(list, std::move(surfaces), context.num_threads);
  }
  context.provenance.AddInput(scenario.patient.surfaces);
  for (const auto& surface : list.surfaces) context.provenance.AddInput(surface.file);
}

/// CT and labels are of one patient.
void RequireOnePatient(const scenario::Patient& patient, const Scene& scene) {
  if (patient.trusts_labels || !scene.ct || !scene.labels) return;
  const auto why = volume::WhyLabelsAreOfAnother(*scene.ct, *scene.labels);
  ACUS_REQUIRE(!why, patient.labels.string(), ": does not fit the CT ", patient.ct.string(), ": ",
               why.value_or(""),
               ". Is it of another patient or scan? Give the label map of this CT; to use it all "
               "the same: --set /patient/trust_labels=true");
}

/// The patient's data for effects of the list: shared, so that its address stays.
effects::PortValues DataOf(const Scene& scene) {
  effects::PortValues values;
  if (scene.ct) values.Set(effects::ports::kCt, scene.ct.get());
  if (scene.labels) values.Set(effects::ports::kLabels, scene.labels.get());
  return values;
}

}  // namespace

const std::shared_ptr<const forces::CtField>& NeedHu(Scene& scene) {
  if (!scene.hu) scene.hu = std::make_shared<forces::CtField>(*scene.ct);
  return scene.hu;
}

namespace {

/// Targets and membranes lie in the labels: what is unsure there is unsure in the session.
void WarnOfUnsureParts(const std::filesystem::path& labels, const RunContext& context) {
  const std::vector<std::string> unsure = segmentation::UnsurePartsBeside(labels);
  if (unsure.empty()) return;
  context.Warn(Message("unsure in the labels of this patient: ", Joined(unsure, "; "),
                       ". Forces, images and targets there may be wrong; look at report.html ",
                       "beside ", labels.filename().string()));
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
    RequireOnePatient(scenario.patient, scene);
    WarnOfUnsureParts(scenario.patient.labels, context);
  }
  if (plan.Needs(effects::ports::kNeedlePreset)) {
    scene.needle = forces::ReadNeedle(scenario.needle);
    context.provenance.AddInput(scenario.needle);
  }
  if (plan.Needs(effects::ports::kProbePreset)) {
    scene.probe = acoustics::ReadProbe(scenario.probe);
    context.provenance.AddInput(scenario.probe);
  }
  for (const CoupledEffect* effect : CoupledEffects()) effect->Load(scenario, scene, context);
  if (!scenario.listed.empty()) {
    const forces::NeedleProperties* needle = scene.needle ? &*scene.needle : nullptr;
    scene.listed = ListedEffects(scenario, plan, DataOf(scene), needle, context);
  }
  return scene;
}

}  // namespace acus::simulation
