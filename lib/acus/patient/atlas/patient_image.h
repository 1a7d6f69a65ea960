// Images of two patients that can be compared, whatever contrast agent each of them was given.
#pragma once

#include <map>

#include "acus/data/volume/volume.h"
#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::atlas {

/// A CT with its tissues, and what of both registration between patients works on.
class PatientImage {
 public:
  /// @param tissues  On the grid of `ct`, which both must outlive this.
  /// @throws InputError if nothing in `tissues` is body.
  PatientImage(const volume::CtVolume& ct, const volume::LabelMap& tissues, double spacing_mm);

  /// The cubic grid over the body.
  const volume::Geometry& geometry() const { return geometry_; }
  const segmentation::Mask& body() const { return body_; }
  double soft_hu() const { return soft_hu_; }  ///< Median of soft tissue.

  /// Soft tissue as HU relative to `soft_hu`, within [-80, 150]; all other tissues have a value of
  /// their own. Where `organs` has a label in `organ_hu`, that stands for the HU of the CT, and all
  /// other soft tissue is even.
  volume::Grid<float> Comparable(double soft_hu, int num_threads) const;
  volume::Grid<float> Imitated(const volume::LabelMap& organs,
                               const std::map<volume::Label, double>& organ_hu, double soft_hu,
                               int num_threads) const;

  volume::Grid<float> Hu(int num_threads) const;  ///< Averaged.

 private:
  volume::Grid<float> Coarse(const volume::Grid<float>& fine, int num_threads) const;

  const volume::CtVolume& ct_;
  const volume::LabelMap& tissues_;
  segmentation::Box box_;  ///< Of the body in the CT, voxels.
  volume::Geometry geometry_;
  segmentation::Mask body_;
  double soft_hu_ = 0.0;
};

}  // namespace acus::atlas
