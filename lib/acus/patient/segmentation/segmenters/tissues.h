// From Hounsfield units to tissues: body, bone, lung, gas, fat, soft tissue, skin.
#pragma once

#include "acus/base/core/run_context.h"
#include "acus/patient/segmentation/voxels/mask.h"
#include "acus/patient/segmentation/voxels/scan_field.h"

namespace acus::segmentation {

/// Values are those of configs/schema/acus-segmentation.schema.json, where they are explained.
struct TissueOptions {
  double body_threshold_hu;
  double body_opening_mm;
  double body_min_part_ml;
  double skin_thickness_mm;
  double fat_upper_hu;
  double air_threshold_hu;
  double gas_median_hu;
  double lung_min_ml;
  double lung_closing_mm;
  double bone_lowest_hu;
  double bone_threshold_hu;
  double bone_certain_hu;
  double bone_min_part_ml;
  double bone_closing_mm;
  double contrast_core_mm;
  double contrast_max_spread;
};

/// The space within the patient's skin, without table, pillows and clothes. Arms and legs count.
///
/// What is denser than air is opened by a ball, which parts the thin table top from the body; the
/// largest part and others of at least body_min_part_ml that look like tissue and are as thick as a
/// limb and are no supports are kept and grown back; cavities are filled slice by slice (axial), so
/// that lungs cut by the border stay inside, also those behind a wall thinner than the ball, and
/// those that the field of view cuts.
/// @param unseen  What lies beyond the scanner's field of view: UnseenBy.
/// @throws InputError if there is nothing denser than air.
Mask FindBody(const volume::CtVolume& ct, const Mask& unseen, const TissueOptions& options,
              int num_threads);

struct AirSpaces {
  Mask lung;  ///< With its vessels.
  Mask gas;   ///< Bowel gas, airways, sinuses.
};
AirSpaces FindAirSpaces(const volume::CtVolume& ct, const Mask& body, const TissueOptions& options,
                        int num_threads);

/// What is dense enough to be bone, before the marrow is filled.
struct BoneFound {
  Mask dense;     ///< Without vessels and organs that hold contrast agent.
  Mask contrast;  ///< Those vessels and organs: thick and even; bone is thin or of a wide spread.
  Mask shell;     ///< `dense`, with small gaps closed.
  bool enhanced = false;      ///< Contrast agent in blood and organs.
  double threshold_hu = 0.0;  ///< The least HU of bone in this scan.
  double noise_hu = 0.0;      ///< Standard deviation, from adjacent voxels of soft tissue.
};
BoneFound FindDenseBone(const volume::CtVolume& ct, const Mask& body, const TissueOptions& options,
                        int num_threads);

/// Cortical bone and the marrow that it encloses; never what is `open` (the spinal canal, discs).
Mask BoneWithMarrow(const volume::CtVolume& ct, const Mask& body, const BoneFound& found,
                    const Mask& open, const TissueOptions& options, int num_threads);

/// Without the rim that the blur of a CT adds to bone: the outer edge lies where HU is half-way
/// between soft tissue and the densest neighbour. Dense voxels lose one layer at most, and none in
/// a scan with contrast agent, whose threshold is higher; soft ones, in gaps that were closed
/// before marrow was filled, lose 2.5 mm. Voxels wider than 1.25 mm stay.
Mask TrimmedToEdge(const volume::CtVolume& ct, const Mask& bone, const BoneFound& found,
                   int num_threads);

/// What was found out about a scan, and used to find its tissues.
struct ScanParameters {
  ScanField field;
  double noise_hu = 0.0;           ///< Standard deviation of adjacent voxels in soft tissue.
  double soft_tissue_hu = 0.0;     ///< Median between fat and bone.
  double bone_threshold_hu = 0.0;  ///< The least HU of bone.
  double contrast_ml = 0.0;        ///< Vessels and organs denser than that.
  bool enhanced = false;           ///< Contrast agent in blood and organs.
  bool has_spine = false;
};

struct TissuesFound {
  volume::LabelMap labels;  ///< All tissues by their standard labels.
  ScanParameters scan;
};

/// @throws InputError if there is no body.
TissuesFound FindTissues(const volume::CtVolume& ct, const TissueOptions& options,
                         const RunContext& context);

/// The grid axis (0, 1, 2) along which slices are most nearly axial.
int AxialAxis(const volume::Geometry& geometry);

/// The (upper) median of CT values, in HU; that of air, -1024, if there are none. Reorders them.
int MedianHu(std::vector<std::int16_t>& values);

}  // namespace acus::segmentation
