// Whether a label map made elsewhere can be of the patient that a CT shows.
#pragma once

#include <string>
#include <vector>

#include "acus/data/volume/volume.h"
#include "acus/patient/segmentation/import/imported_labels.h"

namespace acus::segmentation {

struct ImportFindings {
  std::vector<std::string> impossible;  ///< No patient, or not this one.
  std::vector<std::string> unusual;     ///< To be looked at.
};

/// Holds an import against anatomy (volumes, left and right, up and down, order of vertebrae) and
/// against the CT (the body that was found in it, Hounsfield units).
/// @param found  The tissues that the program found in the CT, on the same grid.
/// @pre all three lie on one grid.
ImportFindings CheckImport(const ImportedLabels& import, const volume::CtVolume& ct,
                           const volume::LabelMap& found);

/// Warns of what is unusual.
/// @throws InputError listing what is impossible, with what to try; a warning instead if that is
///     accepted.
void RequirePlausible(const ImportFindings& findings, const ImportedLabels& import,
                      bool accept_implausible, const RunContext& context);

}  // namespace acus::segmentation
