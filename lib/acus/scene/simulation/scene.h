// The constant data of a plan's stages, loaded once: only what the plan needs.
#pragma once

#include <memory>
#include <optional>

#include "acus/base/core/run_context.h"
#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/ct_slice.h"
#include "acus/imaging/slicing/tracing/surface_tracer.h"
#include "acus/physics/forces/laws/hu_field.h"
#include "acus/physics/forces/models/force_model.h"
#include "acus/physics/forces/probe/probe_force_model.h"
#include "acus/physics/tissue/tissue_model.h"
#include "acus/scene/scenario/scenario.h"
#include "acus/scene/simulation/breathing_scene.h"
#include "acus/scene/simulation/effect_plan.h"
#include "acus/scene/simulation/listed_effects.h"
#include "acus/scene/simulation/needle_shape.h"
#include "acus/scene/simulation/ultrasound_model.h"

namespace acus::simulation {

/// Immutable after LoadScene; shared by any number of simulations and threads.
struct Scene {
  EffectPlan plan;
  Eigen::Isometry3d ct_from_reference = Eigen::Isometry3d::Identity();
  double image_rate_hz = 0.0;
  bool needle_in_ct_slice = false;
  slicing::HuWindow ct_window;  ///< Window of the CT slice.
  bool needle_in_b_mode = false;
  bool force_from_tissue = false;    ///< The deformed tissue gives the force on the hand.
  bool tools_deform_images = false;  ///< Images show what tools do to the tissue.
  bool pressed_by_probe = false;     ///< ... and the probe, as far as its face is below the skin.
  bool pressed_by_proxies = false;   ///< Images show the tissue that the probe's proxies press.
  double warp_spacing_mm = 2.0;
  int inverse_iterations = 12;  ///< ... to invert the deformation at the knots.

  std::optional<Breathing> breathing;              ///< If the plan has breathing.
  std::shared_ptr<const volume::CtVolume> ct;      ///< If the plan reads "ct".
  std::shared_ptr<const volume::LabelMap> labels;  ///< If the plan reads "labels".
  /// If the B-mode follows the patient's surfaces as triangles.
  std::shared_ptr<const tracing::SurfaceTracer> triangles;
  std::optional<forces::NeedleProperties> needle;  ///< If the plan reads "needle preset".
  std::shared_ptr<const forces::CtField> hu;       ///< The CT in HU, if forces read it.
  std::optional<forces::HuTissues> hu_tissues;     ///< If tissues are looked up without labels.
  std::optional<forces::ForceModel> forces;        ///< If the plan has the needle force.
  std::optional<NeedleShapeModel> shape;           ///< If the plan has the needle's shape.
  std::vector<std::shared_ptr<const forces::HuField>> palpated;  ///< Labels for the probe's force.
  bool probe_force_from_tissue = false;  ///< The deformed tissue gives the force on the probe.
  double probe_press_mm = 0.0;           ///< Additional depth along the beam for the probe's force.
  std::optional<forces::ProbeForceModel> probe_force;  ///< If the plan has the probe force.
  std::optional<tissue::TissueModel> tissue;           ///< If the plan has contact or deformation.
  std::optional<acoustics::Probe> probe;               ///< If the plan reads "probe preset".
  std::optional<ImageSettings> b_mode;                 ///< If the plan has the B-mode.
  ListedEffects listed;                                ///< Effects of the list.
};

/// `hu` of the scene, which has a CT; made at the first call.
const std::shared_ptr<const forces::CtField>& NeedHu(Scene& scene);

/// Loads the data that `plan` needs of the scenario, and nothing else.
/// @throws InputError if a file does not exist (as RequireFiles) or is not readable.
Scene LoadScene(const scenario::Scenario& scenario, const EffectPlan& plan, RunContext& context);

}  // namespace acus::simulation
