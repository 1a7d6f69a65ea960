// Labels of one patient, carried to another.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/patient/atlas/patient_image.h"

namespace acus::atlas {

/// A labelled patient, for comparison with others.
struct LabelledPatient {
  std::string name;
  volume::CtVolume ct;
  volume::LabelMap tissues;  ///< As acus-segment finds them.
  volume::LabelMap organs;   ///< As drawn by a person, on the same grid.
};

/// What an atlas says of a patient.
struct CarriedLabels {
  volume::LabelMap organs;     ///< On the patient's coarse grid; 0: nothing.
  volume::LabelMap aligned;    ///< The same before the atlas was bent.
  segmentation::Mask covered;  ///< Where the atlas has the body too.
  /// How alike the two CTs are around each voxel, once bent: 1 / HU^2. Only ratios matter.
  volume::Grid<float> likeness;
  std::map<volume::Label, double> organ_hu;  ///< In this patient: the most frequent HU of each.
};

/// Aligns the bodies, then bends the atlas until its image agrees with the patient's (see
/// breathing_registration::PhaseRegistration). Then twice: the HU of each organ is taken from where
/// the atlas's organ came to lie, the atlas is coloured by them, and bent again. So contrast agent
/// that only one of the two was given does not matter.
/// @return None if the two share too little of the body.
std::optional<CarriedLabels> CarryLabels(const LabelledPatient& atlas, const PatientImage& patient,
                                         const RunContext& context);

/// The HU that is most frequent deep inside a region: the peak of their histogram, blurred by 10
/// HU.
/// @param hu, region  On one grid. @param depth_mm  Only voxels this far inside, if there are any.
double MostFrequentHu(const volume::Grid<float>& hu, const segmentation::Mask& region,
                      double depth_mm, int num_threads);

}  // namespace acus::atlas
