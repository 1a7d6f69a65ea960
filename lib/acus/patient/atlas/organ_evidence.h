// What a CT shows for and against an organ that was found from an atlas.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/patient/atlas/organ_fusion.h"
#include "acus/patient/segmentation/organ_evidence.h"

namespace acus::atlas {

/// One for each part of the organ that segmentation::OrganParts distinguishes.
/// @param middle_x_mm  Of the patient (segmentation::MiddleXMm).
std::vector<segmentation::OrganEvidence> EvidenceOf(const std::string& tissue,
                                                    const FoundOrgan& found,
                                                    const std::optional<double>& middle_x_mm,
                                                    int num_threads);

}  // namespace acus::atlas
