#include "acus/patient/segmentation/lay_imports.h"

#include <cmath>

#include "acus/patient/segmentation/import_gate.h"
#include "acus/patient/segmentation/other_bones.h"

namespace acus::segmentation {

std::string LayImports(const ImportOptions& imports, const volume::CtVolume& ct,
                       volume::LabelMap& labels, const RunContext& context) {
  const volume::LabelMap found = labels;  // What each map is held against.
  std::string report;
  for (const ForeignLabels& map : imports.maps) {
    context.Checkpoint(Message("importing ", map.file.filename().string()), 0.0);
    const ImportedLabels import = ReadImportedLabels(map, ct.geometry, context);
    RequirePlausible(CheckImport(import, ct, found), import, imports.accept_implausible, context);
    const volume::LabelMap tissues = TissuesIn(import);
    report += ImportSentence(import);
    if (import.mapping.all_bones) {
      const double ml = static_cast<double>(DropOtherBones(tissues, labels, context.num_threads)) *
                        ct.geometry.voxel_volume_mm3() / 1000.0;
      if (ml >= 0.5) {
        report += Message(map.file.string(), ": contains every bone; ", std::round(ml),
                          " ml of other bone became soft tissue\n");
      }
    }
    Overlay(tissues, labels);
  }
  return report;
}

}  // namespace acus::segmentation
