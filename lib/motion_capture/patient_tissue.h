// What is tissue in a CT, and the wall along which organs slide.
#pragma once

#include <filesystem>

#include "motion_capture/phase_registration.h"
#include "segmentation/patient_segmentation.h"
#include "volume/volume_io.h"

namespace acus::motion_capture {

/// @param labels   Of the CT; empty: they are found.
/// @param sliding  Find the wall of the cavity: see phantom::FindCavity.
/// @throws InputError if there is no cavity to be found (without ribs, spine or lung).
Tissue TissueOf(const volume::CtVolume& ct, const std::filesystem::path& labels, bool sliding,
                RunContext& context);

}  // namespace acus::motion_capture
