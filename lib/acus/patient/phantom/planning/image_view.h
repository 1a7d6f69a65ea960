// What a probe beside an insertion would see of it, from the labels alone.
#pragma once

#include <map>
#include <string>

#include "acus/patient/phantom/planning/insertion_plan.h"

namespace acus::phantom {

/// Shares from 0 to 1, by a cheap model of a curvilinear abdominal probe (radius 60 mm, 60 degrees,
/// 150 mm deep): beams end at bone, lung and gas, and where more than 3 mm of air lie between face
/// and skin.
struct ImageView {
  double target = 0.0;  ///< Of the target's surroundings, 3 mm in the image plane.
  double needle = 0.0;  ///< Of the path, from 5 mm under the skin to the target.
  double face = 0.0;    ///< Of the face, on skin with at least 20 mm of soft tissue behind it.
  /// Beams that do not reach the depth of the target, by the tissue that ends them; "air" is air
  /// between face and skin.
  std::map<std::string, int> hidden_by;

  /// The target and most of the needle are in the image, and most of the face is of use; on flat
  /// skin 60 % of a curved face is.
  bool IsGood() const { return target >= 0.5 && needle >= 0.5 && face >= 0.5; }
  /// For comparing candidates; from 0 to 4.
  double Score() const { return 2.0 * target + needle + face; }
};

/// The probe lies ahead of the entry, as scripted sessions have it; all 0 without skin there.
ImageView ViewOf(const PatientField& field, const InsertionPlan& plan);

/// "the target, 84 % of the needle; 100 % of the face on soft tissue", and what hides the rest.
std::string ViewText(const ImageView& view);

}  // namespace acus::phantom
