// From a CT to everything that acus-segment writes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/segmentation/import/imported_labels.h"
#include "acus/patient/segmentation/organ_checks.h"
#include "acus/patient/segmentation/quality_parts.h"
#include "acus/patient/segmentation/segmenters/organs.h"
#include "acus/patient/segmentation/segmenters/tissues.h"
#include "acus/patient/segmentation/spine/vertebrae.h"
#include "acus/patient/segmentation/surfaces/surface_extraction.h"
#include "acus/patient/segmentation/voxels/scan_quality.h"

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

/// Finds tissues, then organs from their seeds, then the muscles of the wall.
/// @throws InputError if the volume is no CT of a body; NoAnswerError if no patient is like that.
TissuesFound SegmentPatient(const volume::CtVolume& ct, const SegmentationConfig& config,
                            const RunContext& context);

/// What may be requested beside the labels.
struct Examination {
  bool certainty = false;                  ///< How much the labels depend on the thresholds.
  std::optional<NamedVertebra> start;      ///< The name of one vertebra.
  volume::LabelMap vertebrae = {};         ///< Those of an import (VertebraeIn), or empty.
  std::vector<OrganEvidence> organs = {};  ///< Of those that an atlas found.
};

/// Labels, what is known about them, and what a person should look at.
struct SegmentedPatient {
  volume::LabelMap labels;
  ScanParameters scan;
  std::vector<std::string> warnings;
  Vertebrae vertebrae;
  std::vector<OrganCheck> organs;
  std::vector<PartQuality> parts;
  std::optional<Certainty> certainty;
  std::vector<Agreement> agreement;
};

/// @param found  With imported labels and those from an atlas.
SegmentedPatient Examine(const volume::CtVolume& ct, const SegmentationConfig& config,
                         TissuesFound found, const Examination& examination,
                         const RunContext& context);

/// For people: volumes, thresholds, spine, certainty, and a table of what is sure and what is not.
std::string SummaryOf(const SegmentedPatient& patient);

/// The tissues of a CT: as in `labels`, or, if that is empty, found with the preset default.json.
/// @throws InputError if the labels lie on another grid.
volume::LabelMap TissuesOf(const volume::CtVolume& ct, const std::filesystem::path& labels,
                           RunContext& context);

/// Writes labels.seg.nrrd, body.stl, skin.stl, bone.stl, three previews, two views,
/// report.html, volumes.csv, quality.json, vertebrae.seg.nrrd and vertebrae.csv (if there are any),
/// unsure.nrrd and preview_unsure.png (with a certainty), agreement.csv (if there is a reference)
/// and provenance.json into a new folder, whole or not at all.
void WritePatientFolder(const std::filesystem::path& folder, const volume::CtVolume& ct,
                        const SegmentedPatient& patient, const SegmentationConfig& config,
                        const RunContext& context);

/// A table for people: tissue, Dice, 95 % surface distance, volumes.
std::string AgreementTable(const std::vector<Agreement>& agreement);

}  // namespace acus::segmentation
