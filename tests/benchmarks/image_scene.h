// The scene of the sweep "image".
#pragma once

#include <memory>

#include "acus/imaging/ultrasound/beams/beam_renderer.h"
#include "acus/imaging/ultrasound/columns/alamilla.h"
#include "acus/imaging/ultrasound/columns/bmode.h"
#include "acus/imaging/ultrasound/columns/vidal.h"

namespace acus::benchmarks {

/// Skin, fat, muscle and liver, 60 x 60 x 30 mm; in it a lesion, a vessel and a rib.
struct ImageScene {
  volume::LabelMap labels;
  volume::CtVolume ct;  ///< The same tissues in HU.
  acoustics::TissueAcousticsTable acoustics;
  Eigen::Isometry3d ct_from_probe;
  image::NeedleInImage needle;
};
ImageScene MakeImageScene();

/// Tissue taken along by the needle: 2 mm at its tip. Known where it was at rest; where a place of
/// the image was is found by fixed-point iteration.
class PressedTissue : public slicing::RestMap {
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

}  // namespace acus::benchmarks
