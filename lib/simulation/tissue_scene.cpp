#include "simulation/tissue_scene.h"

#include <utility>

#include "core/error.h"
#include "mechanics/elasticity_table.h"
#include "simulation/simulation.h"

namespace acus::simulation {
namespace {

using scenario::TissueEffect;
using scenario::TissueModelKind;

/// Young's modulus by place, from a label map. The table must know all tissues that are there.
class ModulusMap {
 public:
  ModulusMap(std::shared_ptr<const volume::LabelMap> labels, mechanics::ElasticityTable table)
      : labels_(std::move(labels)),
        table_(std::make_shared<mechanics::ElasticityTable>(std::move(table))),
        index_from_ct_(labels_->geometry.index_from_ct()) {}

  /// MPa; 0 outside the body, and where a tissue has no row.
  double operator()(const Eigen::Vector3d& rest_in_ct_mm) const {
    return table_->tissue[LabelAt(*labels_, index_from_ct_, rest_in_ct_mm)].youngs_modulus_mpa;
  }

 private:
  std::shared_ptr<const volume::LabelMap> labels_;
  std::shared_ptr<const mechanics::ElasticityTable> table_;
  Eigen::Affine3d index_from_ct_;
};

}  // namespace

tissue::TissueModel LoadTissue(const scenario::Scenario& scenario,
                               std::shared_ptr<const volume::LabelMap> labels,
                               RunContext& context) {
  const TissueEffect& effect = *scenario.tissue;
  mechanics::ElasticityTable elasticity = mechanics::ReadElasticityTable(effect.elasticity);
  context.provenance.AddInput(effect.elasticity);
  switch (effect.model) {
    case TissueModelKind::kDisplacementFunctions:
      return tissue::TissueModel(
          tissue::DisplacementFunctions({.influence_radius_mm = effect.influence_radius_mm},
                                        ModulusMap(std::move(labels), std::move(elasticity))));
    case TissueModelKind::kSprings:
    case TissueModelKind::kPlane2010:
    case TissueModelKind::kFem3d:
      break;
  }
  throw InputError(Message(scenario.file.string(), ": /effects/tissue/model: not there yet"));
}

}  // namespace acus::simulation
