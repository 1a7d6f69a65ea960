// Whether organs that were found are as large as, and where, those of a patient can be.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acus/data/volume/volume.h"
#include "acus/patient/segmentation/organ_evidence.h"
#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {

/// What speaks against one organ, or one of a pair.
struct OrganCheck {
  std::string name;  ///< "liver", "kidney_left".
  double volume_ml = 0.0;
  double least_ml = 0.0, most_ml = 0.0;      ///< Of adults.
  std::vector<std::string> doubts;           ///< For people; empty: nothing speaks against it.
  std::optional<double> expected_dice = {};  ///< With a reference; only of organs from an atlas.

  bool is_sure() const { return doubts.empty(); }
};

/// x of the patient's middle, by the spinal canal; none without one.
std::optional<double> MiddleXMm(const volume::LabelMap& labels);

/// An organ by its parts, with their names: kidneys as "kidney_left" and "kidney_right" if there is
/// a middle, all others as they are. Empty parts are omitted.
std::vector<std::pair<std::string, Mask>> OrganParts(const std::string& tissue, const Mask& organ,
                                                     const std::optional<double>& middle_x_mm);

/// Liver, spleen and both kidneys of a label map, those that it has. Checked: volume (the lower
/// limit only if the border of the CT does not cut the organ), one piece, the patient's side and
/// the kidneys' places (from the spinal canal, if there is one), and how far the two kidneys are
/// from alike and from one height.
/// @param evidence  Of organs that an atlas found: these are also unsure with an expected Dice
///     below kRightOrganDice.
std::vector<OrganCheck> CheckOrgans(const volume::LabelMap& labels,
                                    const std::vector<OrganEvidence>& evidence = {});

/// The map with "(unsure)" in the names of tissues with a doubtful organ, for images.
volume::LabelMap WithDoubtsInNames(volume::LabelMap labels, const std::vector<OrganCheck>& organs);

}  // namespace acus::segmentation
