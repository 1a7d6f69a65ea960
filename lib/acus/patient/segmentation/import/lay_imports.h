// Label maps made elsewhere, laid over what the program found.
#pragma once

#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/volume/volume.h"
#include "acus/patient/segmentation/import/imported_labels.h"

namespace acus::segmentation {

struct ImportOptions {
  std::vector<ForeignLabels> maps;  ///< Where several have a tissue, the last remains.
  bool accept_implausible = false;  ///< Only warn of maps that cannot be of this patient.
};

struct LaidImports {
  std::string report;          ///< One line for each map: how many structures, how they are named.
  volume::LabelMap vertebrae;  ///< Single ones that the maps name, see VertebraeIn; may be empty.
};

/// Lays every map over `labels`, after holding it against anatomy and the CT. Where a map that
/// contains every bone has none, bone becomes soft tissue. Gas stays where the map has another
/// tissue than lung.
/// @throws InputError if a map is broken, not understood, or cannot be of this patient.
LaidImports LayImports(const ImportOptions& imports, const volume::CtVolume& ct,
                       volume::LabelMap& labels, const RunContext& context);

}  // namespace acus::segmentation
