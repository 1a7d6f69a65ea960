// The scene of the sweep "image".
#pragma once

#include <memory>

#include "ultrasound/alamilla.h"
#include "ultrasound/beam_renderer.h"
#include "ultrasound/bmode.h"
#include "ultrasound/vidal.h"

namespace acus::tradeoff {

/// Skin, fat, muscle and liver, 60 x 60 x 30 mm; in it a lesion, a vessel and a rib.
struct ImageScene {
  volume::LabelMap labels;
  volume::CtVolume ct;  ///< The same tissues in HU.
  ultrasound::TissueAcousticsTable acoustics;
  Eigen::Isometry3d ct_from_probe;
  ultrasound::NeedleInImage needle;
};
ImageScene MakeImageScene();

/// Tissue taken along by the needle: 2 mm at its tip. Known where it was at rest; where a place of
/// the picture was is found by fixed-point iteration.
class PressedTissue : public ultrasound::RestMap {
 public:
  PressedTissue(const Eigen::Vector3d& tip_mm, int iterations, double spacing_mm)
      : tip_mm_(tip_mm), iterations_(iterations), spacing_mm_(spacing_mm) {}
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                             const Eigen::Vector3d& guess_in_ct_mm) const noexcept override;
  double SpacingMm() const noexcept override { return spacing_mm_; }

 private:
  Eigen::Vector3d tip_mm_;
  int iterations_;
  double spacing_mm_;
};

}  // namespace acus::tradeoff
