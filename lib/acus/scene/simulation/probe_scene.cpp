#include "acus/scene/simulation/probe_scene.h"

#include <bitset>
#include <utility>

#include "acus/physics/forces/laws/occupancy_field.h"
#include "acus/scene/simulation/patient_tables.h"

namespace acus::simulation {
namespace {

using forces::OccupancyField;
using scenario::ProbeForceEffect;

forces::PalpationTool ToolOf(const ProbeForceEffect& effect, const Scene& scene) {
  if (effect.is_fingertip) {
    return forces::FingertipNodes(effect.fingertip_radius_mm, effect.num_proxies);
  }
  return forces::ProbeFaceNodes(acoustics::FaceLengthMm(*scene.probe), effect.face_width_mm,
                                acoustics::FaceRadiusMm(*scene.probe), effect.num_proxies);
}

/// The surface of some tissues of the label map; the scene keeps it.
const forces::HuField* FieldOf(const std::bitset<256>& tissues, Scene& scene) {
  scene.palpated.push_back(std::make_shared<OccupancyField>(*scene.labels, tissues));
  return scene.palpated.back().get();
}

forces::PalpationFields FieldsByLabel(const forces::ForceTable& table, Scene& scene) {
  std::bitset<256> body;
  body.set();
  body.reset(0);
  std::bitset<256> there;
  for (const volume::Label label : scene.labels->voxels) there.set(label);
  forces::PalpationFields fields{FieldOf(body, scene), OccupancyField::kSurface, {}};
  for (const auto& law : table.multi_proxy.structures) {
    if (!there.test(law.tissue)) continue;
    std::bitset<256> tissue;
    tissue.set(law.tissue);
    fields.structures.push_back({FieldOf(tissue, scene), OccupancyField::kSurface, law});
  }
  return fields;
}

forces::PalpationFields FieldsByHu(const forces::ForceTable& table, Scene& scene) {
  const forces::HuField* hu = NeedHu(scene).get();
  forces::PalpationFields fields{hu, table.multi_proxy.skin_hu, {}};
  for (const auto& law : table.multi_proxy.structures) {
    if (law.from_hu) fields.structures.push_back({hu, *law.from_hu, law});
  }
  return fields;
}

}  // namespace

void LoadProbeForce(const scenario::Scenario& scenario, Scene& scene, const RunContext& context) {
  const ProbeForceEffect& effect = *scenario.probe_force;
  scene.probe_press_mm = effect.press_mm;
  scene.probe_force_from_tissue = effect.model == scenario::ProbeForceModelKind::kTissue;
  if (scene.probe_force_from_tissue) return;
  const forces::ForceTable table = ForcesOf(scenario.patient, effect.table, context);
  if (effect.model == scenario::ProbeForceModelKind::kVidal) {
    scene.probe_force.emplace(forces::VidalProbe(table, *NeedHu(scene)));
    return;
  }
  forces::PalpationFields fields =
      effect.reads_labels ? FieldsByLabel(table, scene) : FieldsByHu(table, scene);
  scene.probe_force.emplace(
      forces::MultiProxyProbe(table, ToolOf(effect, scene), std::move(fields)));
  scene.pressed_by_proxies = effect.presses_images && scene.plan.Writes(effects::ports::kRestMap);
}

}  // namespace acus::simulation
