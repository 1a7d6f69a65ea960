// Loads the tissue model of a scene.
#pragma once

#include <memory>

#include "acus/base/core/run_context.h"
#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/physics/forces/laws/hu_field.h"
#include "acus/physics/tissue/tissue_model.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::simulation {

/// Data of the scene that is loaded already.
struct TissueInputs {
  std::shared_ptr<const volume::LabelMap> labels;  ///< Null if the model does not read it.
  std::shared_ptr<const forces::HuField> hu;       ///< Instead of labels, for springs.
  const acoustics::Probe* probe = nullptr;         ///< Null if the probe does not press.
  bool shows_deformation = false;                  ///< An image shows the tissue's deformation.
};

/// @pre scenario.tissue is there.
/// @throws InputError if a file of the model is missing, not readable or not consistent.
tissue::TissueModel LoadTissue(const scenario::Scenario& scenario, const TissueInputs& inputs,
                               RunContext& context);

}  // namespace acus::simulation
