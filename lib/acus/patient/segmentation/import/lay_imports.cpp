#include "acus/patient/segmentation/import/lay_imports.h"

#include <algorithm>
#include <cmath>

#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/import/import_gate.h"
#include "acus/patient/segmentation/imported_vertebrae.h"
#include "acus/patient/segmentation/segmenters/other_bones.h"

namespace acus::segmentation {
namespace {

/// A map's bowel or stomach has its gas in it, which the map does not distinguish; the CT does.
void KeepGas(const volume::LabelMap& found, volume::LabelMap& tissues) {
  const volume::Label gas = volume::LabelOf("gas"), lung = volume::LabelOf("lung");
  for (std::size_t n = 0; n < found.voxels.size(); ++n) {
    if (found.voxels[n] == gas && tissues.voxels[n] != lung) tissues.voxels[n] = 0;
  }
}

}  // namespace

LaidImports LayImports(const ImportOptions& imports, const volume::CtVolume& ct,
                       volume::LabelMap& labels, const RunContext& context) {
  const volume::LabelMap found = labels;  // What each map is held against.
  LaidImports laid;
  for (const ForeignLabels& map : imports.maps) {
    context.Checkpoint(Message("importing ", map.file.filename().string()), 0.0);
    const ImportedLabels import = ReadImportedLabels(map, ct.geometry, context);
    RequirePlausible(CheckImport(import, ct, found), import, imports.accept_implausible, context);
    volume::LabelMap tissues = TissuesIn(import);
    KeepGas(found, tissues);
    laid.report += ImportSentence(import);
    if (import.mapping.all_bones) {
      const double ml = static_cast<double>(DropOtherBones(tissues, labels, context.num_threads)) *
                        ct.geometry.voxel_volume_mm3() / 1000.0;
      if (ml >= 0.5) {
        laid.report += Message(map.file.string(), ": contains every bone; ", std::round(ml),
                               " ml of other bone became soft tissue\n");
      }
    }
    Overlay(tissues, labels);
    const volume::LabelMap vertebrae = VertebraeIn(import);
    if (std::ranges::none_of(vertebrae.voxels, [](auto label) { return label != 0; })) continue;
    if (laid.vertebrae.voxels.empty()) laid.vertebrae = volume::LabelMap(labels.geometry);
    Overlay(vertebrae, laid.vertebrae);
  }
  return laid;
}

}  // namespace acus::segmentation
