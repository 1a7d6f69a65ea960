// Liver, kidneys and spleen of a CT by labelled CTs of other patients.
#pragma once

#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/atlas/atlas_file.h"
#include "acus/patient/segmentation/segmenters/tissues.h"

namespace acus::atlas {

/// Gives liver, kidney and spleen to what is fat, soft tissue or muscle in `labels`; organs that
/// `labels` has already stay as they are. Each atlas patient is bent onto the CT; where their
/// organs lie on average is the prior of a minimal cut on the CT's HU (see the page of the model).
/// Atlas patients that share too little of the body with the CT are omitted with a warning; so are
/// organs with an impossible volume.
/// @param tissues  Settings for the atlas's CTs.
/// @param atlas  Empty, or no organ unknown: nothing happens.
/// @throws InputError if a file of the atlas cannot be read.
/// @throws NoAnswerError if no atlas patient fits, or no organ is found.
void AddAtlasOrgans(const volume::CtVolume& ct, const std::vector<AtlasPatient>& atlas,
                    const segmentation::TissueOptions& tissues, volume::LabelMap& labels,
                    const RunContext& context);

}  // namespace acus::atlas
