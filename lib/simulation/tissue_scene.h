// The tissue model of a scene, from the files that its level needs.
#pragma once

#include <memory>

#include "core/run_context.h"
#include "scenario/scenario.h"
#include "tissue/tissue_model.h"
#include "volume/volume.h"

namespace acus::simulation {

/// @param labels  For levels that read tissues from the label map; others ignore it.
/// @pre scenario.tissue is there.
/// @throws InputError if a file that the level needs is missing, not readable or does not fit.
tissue::TissueModel LoadTissue(const scenario::Scenario& scenario,
                               std::shared_ptr<const volume::LabelMap> labels, RunContext& context);

}  // namespace acus::simulation
