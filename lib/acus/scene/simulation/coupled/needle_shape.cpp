#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/scene/simulation/coupled/coupled_effect.h"
#include "acus/scene/simulation/coupled/declaration.h"
#include "acus/scene/simulation/patient_tables.h"

namespace acus::simulation::coupled {
namespace {

using scenario::Scenario;

/// The inputs of the needle's shape: the path of the force model, and the tissue on it.
Ports ShapeInputs(const Scenario& s) {
  if (!s.shape) return {};
  const bool from_tissue = IsFeltFromTissue(s);
  Ports reads{ports::kNeedle, ports::kForce, ports::kNeedlePreset,
              from_tissue ? ports::kTissueForceTable : ports::kForceTable};
  if (s.shape->model != scenario::NeedleModelKind::kBendable) return reads;
  Add(reads, {from_tissue ? effects::PortRef(ports::kContact) : effects::PortRef(ports::kTissue),
              ports::kNeedleElasticity});
  // The tissues of the scene. A mesh does not list them: then all deformable ones are taken.
  const bool are_labels_read =
      from_tissue ? s.tissue->model != scenario::TissueModelKind::kFem3d && !AreSpringsByHu(s)
                  : !AreTissuesByHu(s);
  if (are_labels_read) Add(reads, {ports::kLabels});
  if (s.breathing) Add(reads, {ports::kBreath});
  return reads;
}

/// Labels of the map; without one, the tissues that HU distinguish, or all that can be deformed. A
/// map that only other stages read is not used here.
std::bitset<256> TissuesOf(const Scene& scene, const mechanics::ElasticityTable& elasticity) {
  std::bitset<256> found;
  if (scene.plan.Reads(ports::kShape, ports::kLabels)) {
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

/// Breath relative to the needle, which is computed at rest: the motion of the tip is subtracted.
class BreathOnPath : public needle::PathMotion {
 public:
  BreathOnPath(const breathing::MotionMap& patient, const breathing::ToolTrack& track)
      : patient_(patient), track_(track) {}
  Eigen::Vector3d NowMm(const Eigen::Vector3d& rest_mm) const noexcept override {
    return track_.rest_mm +
           track_.world_from_rest.conjugate() * (patient_.WorldMm(rest_mm) - track_.world_mm);
  }

 private:
  const breathing::MotionMap& patient_;
  const breathing::ToolTrack& track_;
};

class ShapeStage final : public CoupledStage {
 public:
  explicit ShapeStage(const Scene& scene) : scene_(scene) {}

  void Begin(State& state) const override { state.shape = scene_.shape->NewState(); }

  Sleep Step(StepFrame& frame) const noexcept override {
    State& state = frame.state;
    NeedleShapeInput input{.time_s = frame.time_s(),
                           .valid = frame.sample.needle_valid,
                           .ct_from_needle = frame.out.needle_at_rest.ct_from_tool,
                           .tissue_at_tip = frame.out.tissue_at_tip,
                           .pierced = frame.out.tissue.pierced};
    PathLine path;
    if (!scene_.force_from_tissue) {
      const forces::NeedleTrack& track = forces::TrackOf(state.force);
      path = {track.in_body && track.pierced, track.path.entry_in_ct_mm,
              track.path.direction_in_ct};
      input.path = &path;
    }
    std::optional<BreathOnPath> motion;
    if (frame.tools.tissue_moves && state.needle_track.started) {
      input.motion = &motion.emplace(*frame.tools.patient, state.needle_track);
    }
    scene_.shape->Step(state.shape, input, frame.out.force);
    frame.out.shape = state.shape.shape;
    return scene_.shape->IsAsleep(state.shape) ? frame.outside() : Sleep::kAwake;
  }

 private:
  const Scene& scene_;
};

class NeedleShapeEffect final : public CoupledEffect {
 public:
  std::string_view key() const override { return "needle"; }

  std::vector<PlannedStage> Stages(const Scenario& s, bool /*breath_from_session*/) const override {
    return {StepStage("needle shape", ShapeInputs(s), {ports::kShape})};
  }

  Ports Goals(const Scenario& s) const override {
    if (!s.shape) return {};
    return {ports::kShape};
  }

  bool Offers(const Scenario& s, effects::PortRef port) const override {
    return port == ports::kShape && s.shape;
  }

  std::vector<effects::Knob> Knobs(const Scenario& s) const override {
    if (!s.shape) return {};
    std::vector<effects::Knob> knobs{
        {.name = "needle_model",
         .title = "shape of the needle",
         .key = "model",
         .values = {"rigid", "lateral_beam", "bendable"},
         .papers = {{"lateral_beam", "Augmented-2010"}, {"bendable", "Fortmeier-2016"}}}};
    if (s.shape->model != scenario::NeedleModelKind::kBendable) return knobs;
    knobs.push_back({.name = "needle_nodes",
                     .title = "nodes of the bendable needle",
                     .key = "nodes",
                     .values = {8, 15, 25, 50, 100},
                     .papers = {{25, "Fortmeier-2016, table 1"},
                                {15, "Fortmeier-2016, figure 13"},
                                {50, "Fortmeier-2016, figure 13"}}});
    knobs.push_back({.name = "needle_path_spacing_mm",
                     .title = "nodes of the path that the bendable needle has cut",
                     .unit = "mm",
                     .key = "path_spacing_mm",
                     .values = {8, 4, 2, 1, 0.5}});
    return knobs;
  }

  void AddInputs(const Scenario& s, std::vector<DeclaredInput>& inputs) const override {
    if (!s.shape) return;
    inputs.push_back(
        File(ports::kNeedleElasticity, s.shape->elasticity, "/effects/needle/elasticity"));
  }

  void Load(const Scenario& s, Scene& scene, RunContext& context) const override {
    if (!scene.plan.Writes(ports::kShape)) return;
    const forces::ForceTable table = scene.force_from_tissue
                                         ? ForcesOf(s.patient, s.tissue->table, context)
                                               .ScaledTo(scene.needle->beam.outer_diameter_mm)
                                         : scene.forces->table();
    std::optional<mechanics::ElasticityTable> elasticity;
    std::bitset<256> tissues;
    if (s.shape->model == scenario::NeedleModelKind::kBendable) {
      elasticity = ElasticityOf(s.patient, s.shape->elasticity, context);
      context.provenance.AddInput(s.shape->elasticity);
      tissues = TissuesOf(scene, *elasticity);
    }
    const auto force = s.needle_force->model;
    const bool has_beam = force == scenario::NeedleForceModelKind::kLayered ||
                          force == scenario::NeedleForceModelKind::kMeasured;
    scene.shape.emplace(*s.shape, *scene.needle, table, elasticity ? &*elasticity : nullptr,
                        tissues, has_beam);
  }

  std::unique_ptr<const CoupledStage> NewStage(effects::PortRef writes,
                                               const Scene& scene) const override {
    if (writes != ports::kShape || !scene.shape) return nullptr;
    return std::make_unique<ShapeStage>(scene);
  }
};

}  // namespace

const CoupledEffect& NeedleShape() {
  static const NeedleShapeEffect effect;
  return effect;
}

}  // namespace acus::simulation::coupled
