// What is tissue in a CT, and the wall along which organs slide.
#pragma once

#include <filesystem>

#include "acus/data/volume/volume_io.h"
#include "acus/patient/breathing_registration/phase_registration.h"
#include "acus/patient/segmentation/patient_segmentation.h"

namespace acus::breathing_registration {

/// @param labels   Of the CT; empty: they are found.
/// @param sliding  Find the wall of the cavity: see phantom::FindCavity.
/// @throws InputError if there is no cavity to be found (without ribs, spine or lung).
Tissue TissueOf(const volume::CtVolume& ct, const std::filesystem::path& labels, bool sliding,
                RunContext& context);

}  // namespace acus::breathing_registration
