// From Hounsfield units to tissues: body, bone, lung, gas, fat, soft tissue, skin.
#pragma once

#include "acus/base/core/run_context.h"
#include "acus/patient/segmentation/mask.h"

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
/// largest part and others of at least body_min_part_ml that look like tissue are kept and grown
/// back; cavities are filled slice by slice (axial), so that lungs cut by the border stay inside.
/// @throws InputError if there is nothing denser than air.
Mask FindBody(const volume::CtVolume& ct, const TissueOptions& options, int num_threads);

struct AirSpaces {
  Mask lung;  ///< With its vessels.
  Mask gas;   ///< Bowel gas, airways, sinuses.
};
AirSpaces FindAirSpaces(const volume::CtVolume& ct, const Mask& body, const TissueOptions& options,
                        int num_threads);

/// Cortical bone and the marrow that it encloses, without vessels and organs that hold contrast
/// agent: those are thick and even, bone is thin or has a wide spread of values.
Mask FindBone(const volume::CtVolume& ct, const Mask& body, const TissueOptions& options,
              int num_threads);

/// All tissues by their standard labels.
volume::LabelMap FindTissues(const volume::CtVolume& ct, const TissueOptions& options,
                             const RunContext& context);

/// The grid axis (0, 1, 2) along which slices are most nearly axial.
int AxialAxis(const volume::Geometry& geometry);

/// The (upper) median of CT values, in HU; that of air, -1024, if there are none. Reorders them.
int MedianHu(std::vector<std::int16_t>& values);

}  // namespace acus::segmentation
