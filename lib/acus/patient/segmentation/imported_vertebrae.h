// Single vertebrae of a label map made elsewhere, along the spine that a CT shows.
#pragma once

#include <vector>

#include "acus/patient/segmentation/import/imported_labels.h"
#include "acus/patient/segmentation/spine/vertebrae.h"
#include "acus/patient/segmentation/spine_frame.h"

namespace acus::segmentation {

/// The vertebrae of an import by name: 1 + NumberOfVertebra where there is one; the sacrum as a
/// whole is S1. All 0 if it has none.
volume::LabelMap VertebraeIn(const ImportedLabels& import);

/// The discs (from the feet) with those of a label map: one between the bodies of each two of its
/// vertebrae that follow each other, and none within a body.
std::vector<DiscPlane> DiscsBetweenImported(const volume::LabelMap& imported, const CanalLine& line,
                                            std::vector<DiscPlane> found);

/// Sets what is known of those vertebrae in whose body one of the label map lies.
/// @param evidence  From the head.
void AddKnownNames(const volume::LabelMap& imported, const SpineFrame& frame,
                   std::vector<VertebraEvidence>& evidence);

/// What a label map has by itself: names, and as centres the middle of what is thickest.
Vertebrae VertebraeOfImport(const volume::LabelMap& imported);

}  // namespace acus::segmentation
