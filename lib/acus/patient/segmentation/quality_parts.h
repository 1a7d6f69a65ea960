// What of a segmentation is plausible, what is unsure, where to look, and how to correct it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acus/patient/segmentation/organ_checks.h"
#include "acus/patient/segmentation/segmenters/tissues.h"
#include "acus/patient/segmentation/spine/vertebrae.h"

namespace acus::segmentation {

inline constexpr double kLeastCertainty = 0.8;  ///< Below it a part is unsure.

/// One part of the table with which acus-segment ends. All texts are for people.
struct PartQuality {
  std::string name;  ///< A tissue, "kidney_left", "names of vertebrae".
  bool is_sure = true;
  std::string why;           ///< Measures, and if unsure, what speaks against it.
  std::string look_at;       ///< Files; empty if it is sure.
  std::string correct;       ///< Options of acus-segment; empty if it is sure.
  bool is_in_labels = true;  ///< As a tissue, so that a scenario may rely on it.
  /// Of cases with and without doubts, the share whose Dice with the reference is at least 0.8
  /// (organs: kRightOrganDice); measured by segmentation_measures. Empty for what has no such
  /// cases: organs that do not come from an atlas, for example.
  std::optional<double> certainty = {};
  std::optional<double> expected_dice = {};  ///< Of organs from an atlas.
};

/// Organs, names of vertebrae, spinal canal, discs and ligaments, bone, and skin: those that there
/// are, and the spine if it is missing. "Sure" means that nothing speaks against it, and that its
/// certainty is at least kLeastCertainty.
std::vector<PartQuality> PartsOf(const volume::LabelMap& labels, const ScanParameters& scan,
                                 const Vertebrae& vertebrae, const std::vector<OrganCheck>& organs,
                                 int num_threads);

/// A table, and a line for each correction.
std::string PartsTable(const std::vector<PartQuality>& parts);

/// "kidney_left (larger than 270 ml)" for the unsure parts of a label map, by the quality.json
/// beside it; empty if there is none, or none that acus-segment wrote.
std::vector<std::string> UnsurePartsBeside(const std::filesystem::path& labels_file);

}  // namespace acus::segmentation
