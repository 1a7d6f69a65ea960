// Whether organs that were found are as large as, and where, those of a patient can be.
#pragma once

#include <string>
#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::segmentation {

/// What speaks against one organ, or one of a pair.
struct OrganCheck {
  std::string name;  ///< "liver", "kidney_left".
  double volume_ml = 0.0;
  double least_ml = 0.0, most_ml = 0.0;  ///< Of adults.
  std::vector<std::string> doubts;       ///< For people; empty: nothing speaks against it.

  bool is_sure() const { return doubts.empty(); }
};

/// Liver, spleen and both kidneys of a label map, those that it has. Checked: volume (the lower
/// limit only if the border of the CT does not cut the organ), one piece, the patient's side (from
/// the spinal canal, if there is one), and how far the two kidneys are from alike and from one
/// height.
std::vector<OrganCheck> CheckOrgans(const volume::LabelMap& labels);

/// The map with "(unsure)" in the names of tissues with a doubtful organ, for images.
volume::LabelMap WithDoubtsInNames(volume::LabelMap labels, const std::vector<OrganCheck>& organs);

}  // namespace acus::segmentation
