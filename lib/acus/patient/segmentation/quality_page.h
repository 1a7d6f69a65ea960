// report.html of a segmentation: what a person looks at before a scene is made on it.
#pragma once

#include <filesystem>

#include "acus/patient/segmentation/patient_segmentation.h"

namespace acus::segmentation {

/// Writes view_back.png and view_front.png: bone and organs without the tissue around them, shaded,
/// as seen from behind and from the front.
void WriteViews(const std::filesystem::path& folder, const volume::LabelMap& labels);

/// Writes report.html into a folder that holds the previews and the views: what is sure and unsure
/// and how to correct it, warnings, slices with outlines, views in 3D, and volumes beside those of
/// adults.
void WriteQualityPage(const std::filesystem::path& folder, const SegmentedPatient& patient,
                      const nlohmann::json& provenance);

}  // namespace acus::segmentation
