#include "acus/scene/simulation/tissue_scene.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/data/mesh/surface_io.h"
#include "acus/data/transforms/landmarks.h"
#include "acus/data/volume/label_lookup.h"
#include "acus/physics/mechanics/condensation/compliance_file.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/mechanics/elements/element_names.h"
#include "acus/scene/simulation/needle_line.h"
#include "acus/scene/simulation/patient_tables.h"

namespace acus::simulation {
namespace {

using scenario::TissueEffect;
using scenario::TissueModelKind;

/// The label map at any point; shares ownership of the map.
class TissueMap {
 public:
  explicit TissueMap(std::shared_ptr<const volume::LabelMap> labels)
      : labels_(std::move(labels)), index_from_ct_(labels_->geometry.index_from_ct()) {}

  volume::Label operator()(const Eigen::Vector3d& rest_in_ct_mm) const {
    return volume::LabelAt(*labels_, index_from_ct_, rest_in_ct_mm);
  }

  std::bitset<256> Tissues() const {
    std::bitset<256> found;
    for (const volume::Label label : labels_->voxels) found.set(label);
    return found;
  }

 private:
  std::shared_ptr<const volume::LabelMap> labels_;
  Eigen::Affine3d index_from_ct_;
};

tissue::TissueModel Functions(const TissueEffect& effect, const TissueMap& tissues,
                              const mechanics::ElasticityTable& elasticity, RunContext& context) {
  // MPa. Bone has no row: it does not move.
  const auto modulus = [tissues, rows = elasticity.tissue](const Eigen::Vector3d& rest_in_ct_mm) {
    const volume::Label tissue = tissues(rest_in_ct_mm);
    const double modulus_mpa = rows[tissue].youngs_modulus_mpa;
    if (tissue == 0 || modulus_mpa > 0.0) return modulus_mpa;
    return std::numeric_limits<double>::infinity();
  };
  tissue::DisplacementFunctionSettings settings;
  if (effect.printed_form) {
    settings = tissue::DisplacementFunctionSettings::AsPrinted();
    context.Warn(
        "effects/tissue/displacement_functions/form \"printed\" takes the formulas to the letter: "
        "tissue folds and has steps, and images show it; \"smooth\" has neither");
  }
  settings.influence_radius_mm = effect.influence_radius_mm;
  if (effect.tip_length_mm > 0.0) settings.tip_length_mm = effect.tip_length_mm;
  return tissue::TissueModel(tissue::DisplacementFunctions(settings, modulus));
}

/// The needle's data for models that touch it.
struct NeedleParts {
  forces::ForceTable table;
  forces::NeedleProperties needle;
};

NeedleParts ReadNeedleParts(const scenario::Scenario& scenario, RunContext& context) {
  context.provenance.AddInput(scenario.tissue->table);
  context.provenance.AddInput(scenario.needle);
  return {ForcesOf(scenario.patient, scenario.tissue->table, context),
          forces::ReadNeedle(scenario.needle)};
}

tissue::TissueModel Springs(const TissueEffect& effect, const TissueMap& tissues,
                            const mechanics::ElasticityTable& elasticity,
                            const NeedleParts& parts) {
  return tissue::TissueModel(
      tissue::SpringModel({.node_spacing_mm = effect.path_spacing_mm,
                           .influence_radius_mm = effect.influence_radius_mm},
                          parts.table, parts.needle, elasticity, tissues.Tissues(), tissues));
}

/// Without labels: tissues and parameters by the HU of the CT, with the table.
tissue::TissueModel SpringsByHu(const TissueEffect& effect,
                                const std::shared_ptr<const forces::HuField>& hu,
                                const mechanics::ElasticityTable& elasticity,
                                const NeedleParts& parts) {
  std::bitset<256> tissues;
  for (const forces::HuTissues::Row& row : parts.table.hu_tissues.rows) tissues.set(row.tissue);
  const auto hu_at = [hu](const Eigen::Vector3d& rest_in_ct_mm) { return hu->HuAt(rest_in_ct_mm); };
  const auto tissue_at = [hu, rows = parts.table.hu_tissues](const Eigen::Vector3d& rest_in_ct_mm) {
    return rows.At(hu->HuAt(rest_in_ct_mm));
  };
  return tissue::TissueModel(
      tissue::SpringModel({.node_spacing_mm = effect.path_spacing_mm,
                           .influence_radius_mm = effect.influence_radius_mm},
                          parts.table, parts.needle, elasticity, tissues, tissue_at, hu_at));
}

/// A plane through entry and target of the needle's path, as nearly transverse as that allows: the
/// slice of the CT that a probe beside the needle shows.
tissue::PlanePlacement PlaneThrough(const std::filesystem::path& corridor, double& length_mm) {
  const NeedleLine line = ReadNeedleLine(corridor);
  tissue::PlanePlacement plane;
  plane.entry_in_ct_mm = line.entry_in_ct_mm;
  length_mm = line.way_mm.norm();
  plane.axis_in_ct = line.way_mm / length_mm;
  const Eigen::Vector3d across = plane.axis_in_ct.cross(Eigen::Vector3d::UnitZ());
  // A needle along the body has no transverse plane: any plane is as good.
  plane.across_in_ct = across.norm() > 0.1 ? across : Eigen::Vector3d::UnitX();
  return plane;
}

tissue::TissueModel Plane(const scenario::Scenario& scenario, const TissueMap& tissues,
                          const mechanics::ElasticityTable& elasticity, const NeedleParts& parts,
                          RunContext& context) {
  const TissueEffect& effect = *scenario.tissue;
  double length_mm = 0.0;
  const tissue::PlanePlacement plane = PlaneThrough(scenario.patient.corridor, length_mm);
  context.provenance.AddInput(scenario.patient.corridor);
  context.Checkpoint("inverting the planes", 0.0);
  return tissue::TissueModel(
      tissue::PlaneModel2010({.spacing_mm = effect.plane_spacing_mm,
                              .width_mm = effect.plane_width_mm,
                              .depth_mm = length_mm + effect.plane_beyond_mm,
                              .thickness_mm = effect.plane_thickness_mm,
                              .update = effect.plane_full_update ? tissue::PlaneUpdate::kFull
                                                                 : tissue::PlaneUpdate::kRestricted,
                              .num_turned = effect.plane_turned},
                             plane, parts.table, parts.needle, elasticity, tissues));
}

/// Where tissue may stiffen: around the needle's path, from outside the skin.
tissue::StrainSettings StrainOf(const scenario::Scenario& scenario, RunContext& context) {
  constexpr double kOutsideMm = 5.0;  // Skin can bulge above the point that was marked on it.
  constexpr double kRadiusMm = 10.0;
  const NeedleLine line = ReadNeedleLine(scenario.patient.corridor);
  context.provenance.AddInput(scenario.patient.corridor);
  tissue::StrainSettings strain;
  strain.corridor = {line.entry_in_ct_mm - kOutsideMm * line.way_mm.normalized(),
                     line.entry_in_ct_mm + line.way_mm, kRadiusMm};
  strain.max_nodes = scenario.tissue->strain_nodes;
  strain.iterations = scenario.tissue->strain_iterations;
  return strain;
}

tissue::TissueModel Fem(const scenario::Scenario& scenario, const TissueInputs& inputs,
                        const mechanics::ElasticityTable& elasticity, const NeedleParts& parts,
                        RunContext& context) {
  const TissueEffect& effect = *scenario.tissue;
  const std::filesystem::path& file = scenario.patient.mesh;
  context.Checkpoint("reading the mesh", 0.0);
  const mesh::TetraMesh mesh = mesh::ReadTetraMesh(file);
  context.provenance.AddInput(file);
  const mechanics::CondensedTissue condensed = mechanics::OpenCompliance(
      file.parent_path() / "compliance.acc", mesh, elasticity,
      mechanics::ElementNamed(effect.element,
                              scenario.file.string() + ": /effects/tissue/fe_3d/element"));
  tissue::FemContactSettings settings{.contact_spacing_mm = effect.contact_spacing_mm};
  if (effect.probe_contact)
    settings.probe = {.length_mm = acoustics::FaceLengthMm(*inputs.probe),
                      .radius_mm = acoustics::FaceRadiusMm(*inputs.probe)};
  if (effect.finite_strain) {
    settings.strain = StrainOf(scenario, context);
    settings.strain->element = mechanics::ElementNamed(effect.element, "element");
  }
  tissue::FemTissue model{tissue::FemNeedleModel(mesh, condensed.compliance, elasticity,
                                                 parts.table, parts.needle, settings),
                          nullptr};
  if (inputs.shows_deformation) {
    model.image = std::make_shared<const tissue::FemImage>(mesh, condensed);
  }
  return tissue::TissueModel(std::move(model));
}

}  // namespace

tissue::TissueModel LoadTissue(const scenario::Scenario& scenario, const TissueInputs& inputs,
                               RunContext& context) {
  const TissueEffect& effect = *scenario.tissue;
  const mechanics::ElasticityTable elasticity =
      ElasticityOf(scenario.patient, effect.elasticity, context);
  context.provenance.AddInput(effect.elasticity);
  switch (effect.model) {
    case TissueModelKind::kDisplacementFunctions:
      return Functions(effect, TissueMap(inputs.labels), elasticity, context);
    case TissueModelKind::kSprings:
      if (inputs.hu) {
        return SpringsByHu(effect, inputs.hu, elasticity, ReadNeedleParts(scenario, context));
      }
      return Springs(effect, TissueMap(inputs.labels), elasticity,
                     ReadNeedleParts(scenario, context));
    case TissueModelKind::kFem3d:
      return Fem(scenario, inputs, elasticity, ReadNeedleParts(scenario, context), context);
    case TissueModelKind::kPlane2010:
      return Plane(scenario, TissueMap(inputs.labels), elasticity,
                   ReadNeedleParts(scenario, context), context);
  }
  ACUS_ASSERT(false);
}

}  // namespace acus::simulation
