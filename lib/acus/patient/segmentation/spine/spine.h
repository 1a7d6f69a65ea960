// The spine of a CT: its canal, discs, ligaments and the muscles beside it.
#pragma once

#include <optional>
#include <string>

#include "acus/patient/segmentation/segmenters/tissues.h"

namespace acus::segmentation {

/// Masks on the grid of the CT. Where two overlap, the earlier one counts.
struct Spine {
  Mask canal;
  Mask disc;
  Mask ligament;  ///< Ligamentum flavum, interspinous and supraspinous ligaments.
  Mask muscle;    ///< Behind the vertebral bodies, where it is not bone.
};

/// Nothing if the CT shows too little of a spine: fewer than about 14 mm of closed arches in a row,
/// or axes more than 30 degrees off the patient's.
std::optional<Spine> FindSpine(const volume::CtVolume& ct, const Mask& body, const BoneFound& bone,
                               const TissueOptions& options, int num_threads);

/// For people: how much spinal canal `labels` have, or that no spine was found.
std::string SpineSentence(const volume::LabelMap& labels);

}  // namespace acus::segmentation
