// Liver, kidneys and spleen of a CT by labelled CTs of other patients.
#pragma once

#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/atlas/atlas_file.h"
#include "acus/patient/atlas/patient_map.h"
#include "acus/patient/segmentation/organ_evidence.h"
#include "acus/patient/segmentation/segmenters/tissues.h"

namespace acus::atlas {

/// The CT and the labels of an atlas patient; lesions count as the organ around them.
/// @param tissues  Settings for the tissues of its CT.
/// @throws InputError if a file cannot be read.
LabelledPatient ReadLabelledPatient(const AtlasPatient& patient,
                                    const segmentation::TissueOptions& tissues,
                                    const RunContext& context);

/// Gives liver, kidney and spleen to what is fat, soft tissue or muscle in `labels`; organs that
/// `labels` has already stay as they are. Each atlas patient is bent onto the CT; where their
/// organs lie on average, weighted by how alike the two CTs are there, is the prior of a minimal
/// cut on the CT's HU (see the page of the model). Atlas patients that share too little of the body
/// with the CT are omitted with a warning; so are organs with an impossible volume.
/// @param atlas  Empty, or no organ unknown: nothing happens.
/// @return What speaks for and against each organ that was added.
/// @throws NoAnswerError if no atlas patient fits, or no organ is found.
std::vector<segmentation::OrganEvidence> AddAtlasOrgans(const volume::CtVolume& ct,
                                                        const std::vector<LabelledPatient>& atlas,
                                                        volume::LabelMap& labels,
                                                        const RunContext& context);

/// The same from files. Of two patients or more, each finds the organs of the next as well: the
/// evidence has how well.
/// @throws InputError if a file of the atlas cannot be read.
std::vector<segmentation::OrganEvidence> AddAtlasOrgans(const volume::CtVolume& ct,
                                                        const std::vector<AtlasPatient>& atlas,
                                                        const segmentation::TissueOptions& tissues,
                                                        volume::LabelMap& labels,
                                                        const RunContext& context);

/// The last step of AddAtlasOrgans: organs from atlas patients that are bent onto the CT.
/// @param image  Of the CT and `labels`. @param carried  By CarryLabels onto `image`.
std::vector<segmentation::OrganEvidence> AddCarriedOrgans(const PatientImage& image,
                                                          std::vector<CarriedLabels> carried,
                                                          volume::LabelMap& labels,
                                                          const RunContext& context);

inline constexpr double kAtlasSpacingMm = 3.0;  ///< Grid of registration and cut.

}  // namespace acus::atlas
