// Whether a segmentation can be that of a patient, and where it is unsure.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/patient/segmentation/quality_parts.h"
#include "acus/patient/segmentation/segmenters/tissues.h"

namespace acus::segmentation {

/// How much a segmentation depends on its thresholds: tissues found again with thresholds 20 HU
/// (air: 60 HU) and sizes a fifth off, both ways.
struct Certainty {
  struct Tissue {
    std::string name;
    double dice = 1.0;  ///< The lower of two, between what was found and a variant of it.
  };
  std::vector<Tissue> tissues;
  volume::Grid<std::uint8_t> unsure;  ///< In how many of the two variants a voxel's label differs.
  double unsure_ml = 0.0;
};

/// Takes twice as long as FindTissues.
Certainty FindCertainty(const volume::CtVolume& ct, const TissueOptions& options,
                        const volume::LabelMap& labels, const RunContext& context);

/// @throws InputError if all values of `ct` lie between 0 and 255, so that it is a mask, a label
/// map or an image of 8 bits.
void RequireCt(const volume::CtVolume& ct);

/// What a person should look at: no bone, values that are no Hounsfield units, a body that is cut,
/// noise, thick slices. Each says what to do. @throws NoAnswerError if more than 60 % of the body
/// would be bone (30 % in a volume without air), which no patient has.
std::vector<std::string> WarningsOf(const volume::CtVolume& ct, const TissuesFound& found);

/// quality.json: what was found out about the scan, the warnings, what is sure and what is not,
/// and the certainty if there is one.
void WriteQuality(const std::filesystem::path& path, const ScanParameters& scan,
                  const std::vector<std::string>& warnings, const std::vector<PartQuality>& parts,
                  const std::optional<Certainty>& certainty);

}  // namespace acus::segmentation
