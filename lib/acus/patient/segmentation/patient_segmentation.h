// From a CT to everything that acus-segment writes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/segmentation/imported_labels.h"
#include "acus/patient/segmentation/organs.h"
#include "acus/patient/segmentation/surface_extraction.h"
#include "acus/patient/segmentation/tissues.h"

namespace acus::segmentation {

struct SegmentationConfig {
  TissueOptions tissues;
  std::vector<OrganSeed> organs;
  SurfaceOptions skin_surface;
  SurfaceOptions bone_surface;
};

/// Reads a file of format acus-segmentation/1. @throws InputError naming every problem.
SegmentationConfig ReadSegmentationConfig(const std::filesystem::path& path);

/// How one tissue agrees with a reference.
struct Agreement {
  std::string tissue;  ///< A tissue, or "body": everything but outside.
  double dice = 0.0;
  double surface_distance95_mm = 0.0;
  double reference_ml = 0.0;
  double ours_ml = 0.0;
};

/// Holds a label map against a reference, for each tissue that both have, and for the body if the
/// reference covers it. Voxels that are skin in `labels` count for the body only.
std::vector<Agreement> CompareWithReference(const volume::LabelMap& labels,
                                            const ForeignLabels& reference,
                                            const RunContext& context);

/// Finds tissues, then organs from their seeds.
volume::LabelMap SegmentPatient(const volume::CtVolume& ct, const SegmentationConfig& config,
                                const RunContext& context);

/// The tissues of a CT: as in `labels`, or, if that is empty, found with the preset default.json.
/// @throws InputError if the labels lie on another grid.
volume::LabelMap TissuesOf(const volume::CtVolume& ct, const std::filesystem::path& labels,
                           RunContext& context);

/// Writes labels.seg.nrrd, skin.stl, bone.stl, three previews, volumes.csv, agreement.csv (if there
/// is a reference) and provenance.json into a new folder, whole or not at all.
void WritePatientFolder(const std::filesystem::path& folder, const volume::CtVolume& ct,
                        const volume::LabelMap& labels, const SegmentationConfig& config,
                        const std::vector<Agreement>& agreement, const RunContext& context);

/// A table for people: tissue, Dice, 95 % surface distance, volumes.
std::string AgreementTable(const std::vector<Agreement>& agreement);

}  // namespace acus::segmentation
