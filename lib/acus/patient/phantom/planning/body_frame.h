// What windows on the skin refer to: the middle of a patient and the trunk.
#pragma once

#include <map>

#include "acus/data/volume/volume.h"
#include "acus/patient/phantom/anatomy/anatomy.h"

namespace acus::phantom {

/// The middle plane and the width of the trunk by height. CT space, LPS, mm.
class BodyFrame {
 public:
  explicit BodyFrame(const volume::LabelMap& labels);

  /// x of the middle at a height: that of the spinal canal there or nearest to it, without a canal
  /// that of all bone, without bone that of the body.
  double MiddleXMm(double z_mm) const;

  /// +1 on the patient's left of the middle, -1 on the right.
  double Side(const Eigen::Vector3d& point_ct_mm) const;

  /// False in shoulders, arms and neck: beside the lungs of this height or, below them, farther out
  /// than their widest slice, or above them. True everywhere if the map has no lung.
  bool IsTrunk(const Eigen::Vector3d& point_ct_mm) const;

  /// Whether lung is at this height: no level for a lumbar puncture.
  bool HasLungAt(double z_mm) const;

 private:
  struct Extent {
    double low_mm, high_mm;
  };
  int BinOf(double z_mm) const;

  std::map<int, double> canal_x_mm_;  ///< By height, in bins of a few mm.
  std::map<int, Extent> lung_x_mm_;
  Extent widest_lung_x_mm_{};
  double other_middle_x_mm_ = 0.0;
};

}  // namespace acus::phantom
