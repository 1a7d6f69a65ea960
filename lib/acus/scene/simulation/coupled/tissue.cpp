#include "acus/scene/simulation/coupled/coupled_effect.h"
#include "acus/scene/simulation/coupled/declaration.h"
#include "acus/scene/simulation/tissue_scene.h"

namespace acus::simulation::coupled {
namespace {

using scenario::Scenario;

/// The inputs of the tissue under a tool, besides the tool.
Ports ContactInputs(const Scenario& s) {
  if (!s.tissue) return {};
  Ports reads{ports::kNeedle, ports::kNeedlePreset, ports::kTissueElasticity,
              ports::kTissueForceTable};
  switch (s.tissue->model) {
    case scenario::TissueModelKind::kDisplacementFunctions:
      return {};  // Nothing at every step: see DeformationInputs.
    case scenario::TissueModelKind::kSprings:
      Add(reads, {AreSpringsByHu(s) ? effects::PortRef(ports::kCt) : ports::kLabels});
      break;
    case scenario::TissueModelKind::kPlane2010:
      Add(reads, {ports::kLabels, ports::kCorridor});
      break;
    case scenario::TissueModelKind::kFem3d:
      Add(reads, {ports::kMesh});
      if (s.tissue->finite_strain) Add(reads, {ports::kCorridor});
      if (s.tissue->probe_contact) Add(reads, {ports::kProbePoses, ports::kProbePreset});
      break;
  }
  if (s.tissue->probe_contact) AddMotion(s, reads);
  return reads;
}

/// The inputs of the deformation in the images.
Ports DeformationInputs(const Scenario& s) {
  Ports reads;
  if (s.tissue && s.tissue->image) {
    reads = s.tissue->TouchesNeedle()
                ? Ports{ports::kContact}
                : Ports{ports::kForce, ports::kLabels, ports::kTissueElasticity};
    if (s.tissue->model == scenario::TissueModelKind::kFem3d) reads.push_back(ports::kMesh);
  }
  if (s.breathing && s.breathing->image) Add(reads, {ports::kBreath});
  if (IsTissueMoved(s)) Add(reads, {ports::kTissueMotion});
  if (IsWrittenByListed(s, ports::kSwelling)) Add(reads, {ports::kSwelling});
  if (s.probe_force && s.probe_force->presses_images) {
    Add(reads, {ports::kProbe, ports::kProbeForce});
  }
  return reads;
}

/// Parameters of the model itself.
void AddModelKnobs(const Scenario& s, std::vector<effects::Knob>& knobs) {
  switch (s.tissue->model) {
    case scenario::TissueModelKind::kSprings:
      knobs.push_back({.name = "spring_path_spacing_mm",
                       .title = "nodes of the path that hold the needle by springs",
                       .unit = "mm",
                       .key = "springs/path_spacing_mm",
                       .values = {8, 4, 2, 1, 0.5}});
      break;
    case scenario::TissueModelKind::kPlane2010:
      // 19 x 19 nodes over a plane of 90 mm are the 361 of the mesh that the paper names.
      knobs.push_back({.name = "fe_2d_spacing_mm",
                       .title = "nodes of the plane of finite elements",
                       .unit = "mm",
                       .key = "fe_2d/spacing_mm",
                       .values = {8, 5, 3, 2, 1.5},
                       .papers = {{5, "361 nodes, Augmented-2010"}}});
      break;
    case scenario::TissueModelKind::kFem3d:
      knobs.push_back({.name = "contact_spacing_mm",
                       .title = "points along the needle that touch the finite elements",
                       .unit = "mm",
                       .key = "fe_3d/contact_spacing_mm",
                       .values = {8, 4, 3, 2, 1.5, 1}});
      knobs.push_back({.name = "mesh",
                       .title = "mesh of the tissue",
                       .key = "/patient/mesh",
                       .is_folder = true,
                       .scenario_value = s.patient.mesh.string()});
      break;
    case scenario::TissueModelKind::kDisplacementFunctions:
      break;
  }
}

class ContactStage final : public CoupledStage {
 public:
  explicit ContactStage(const Scene& scene) : scene_(scene) {}

  void Begin(State& state) const override { state.tissue = scene_.tissue->NewState(); }

  Sleep Step(StepFrame& frame) const noexcept override {
    const Eigen::Vector3d axis_in_ct = frame.axis_in_ct();
    const Eigen::Vector3d tip_in_ct_mm = frame.tip_in_ct_mm();
    frame.out.tissue = scene_.tissue->Step(
        frame.state.tissue,
        {.time_s = frame.time_s(),
         .needle_valid = frame.sample.needle_valid,
         .tip_in_ct_mm =
             scene_.shape ? scene_.shape->LockedTip(frame.state.shape, tip_in_ct_mm) : tip_in_ct_mm,
         .axis_in_ct =
             scene_.shape ? scene_.shape->LockedAxis(frame.state.shape, axis_in_ct) : axis_in_ct,
         .tip_direction_in_ct = frame.state.shape.tip_direction_in_ct,
         .probe_valid = frame.sample.probe_valid,
         .ct_from_probe = scene_.probe_force_from_tissue
                              ? PressedProbe(frame.tools, scene_.probe_press_mm)
                              : frame.tools.probe.ct_from_tool});
    return frame.out.tissue.touched ? Sleep::kAwake : Sleep::kUntouched;
  }

 private:
  const Scene& scene_;
};

class TissueEffect final : public CoupledEffect {
 public:
  std::string_view key() const override { return "tissue"; }

  std::vector<PlannedStage> Stages(const Scenario& s, bool /*breath_from_session*/) const override {
    return {StepStage("tissue contact", ContactInputs(s), {ports::kContact}),
            ImageStage("deformation", DeformationInputs(s), {ports::kRestMap})};
  }

  Ports Goals(const Scenario& s) const override {
    if (!s.tissue || !s.tissue->TouchesNeedle()) return {};
    return {ports::kContact};
  }

  Ports Helpers(const Scenario& s) const override {
    if (!s.tissue || !s.tissue->image) return {};
    return {ports::kRestMap};
  }

  bool Offers(const Scenario& s, effects::PortRef port) const override {
    return port == ports::kRestMap && ShowsDeformation(s);
  }

  std::vector<effects::Knob> Knobs(const Scenario& s) const override {
    if (!s.tissue) return {};
    std::vector<effects::Knob> knobs{
        {.name = "tissue_model",
         .title = "model of the tissue that tools deform",
         .key = "model",
         .values = {"displacement_functions", "springs", "fe_2d", "fe_3d"},
         .papers = {{"displacement_functions", "Alamilla-2021"},
                    {"springs", "Fortmeier-2016"},
                    {"fe_2d", "Augmented-2010"}}}};
    AddModelKnobs(s, knobs);
    if (!s.tissue->image || !HasProbeImage(s)) return knobs;
    knobs.push_back({.name = "tissue_warp_spacing_mm",
                     .title = "knots at which images evaluate the tissue's motion",
                     .unit = "mm",
                     .key = "warp_spacing_mm",
                     .acts_on = effects::ActsOn::kImage,
                     .values = {16, 8, 4, 2, 1, 0.5}});
    knobs.push_back({.name = "tissue_inverse_iterations",
                     .title = "iterations to find where a knot was at rest",
                     .key = "inverse_iterations",
                     .acts_on = effects::ActsOn::kImage,
                     .values = {1, 2, 4, 8, 12, 24}});
    return knobs;
  }

  void AddInputs(const Scenario& s, std::vector<DeclaredInput>& inputs) const override {
    if (!s.tissue) return;
    inputs.push_back(
        File(ports::kTissueElasticity, s.tissue->elasticity, "/effects/tissue/elasticity"));
    inputs.push_back(File(ports::kTissueForceTable, s.tissue->table, "/effects/tissue/table"));
  }

  void Load(const Scenario& s, Scene& scene, RunContext& context) const override {
    scene.tools_deform_images = scene.plan.Writes(ports::kRestMap) && s.tissue && s.tissue->image;
    if (!scene.plan.Writes(ports::kContact) && !scene.tools_deform_images) return;
    const bool are_springs_by_hu = scene.plan.Reads(ports::kContact, ports::kCt);
    if (are_springs_by_hu) {
      context.Warn(
          "there is no label map: the springs' tissues are identified by the CT's HU, as "
          "effects/tissue/table says");
    }
    scene.tissue = LoadTissue(s,
                              {.labels = scene.labels,
                               .hu = are_springs_by_hu ? NeedHu(scene) : nullptr,
                               .probe = scene.probe ? &*scene.probe : nullptr,
                               .shows_deformation = scene.tools_deform_images},
                              context);
    scene.pressed_by_probe =
        scene.tools_deform_images && s.tissue->pressed_by_probe && scene.probe && scene.labels;
    scene.warp_spacing_mm = s.tissue->warp_spacing_mm;
    scene.inverse_iterations = s.tissue->inverse_iterations;
  }

  std::unique_ptr<const CoupledStage> NewStage(effects::PortRef writes,
                                               const Scene& scene) const override {
    if (writes != ports::kContact) return nullptr;
    return std::make_unique<ContactStage>(scene);
  }
};

}  // namespace

const CoupledEffect& Tissue() {
  static const TissueEffect effect;
  return effect;
}

}  // namespace acus::simulation::coupled
