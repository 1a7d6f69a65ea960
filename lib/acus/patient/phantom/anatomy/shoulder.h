// A right shoulder for the puncture of the subacromial bursa: Alamilla-2021, fig. 7.
#pragma once

#include "acus/patient/phantom/anatomy/anatomy.h"

namespace acus::phantom {

/// Humeral head at the origin, lateral is -x. All lengths before scale. A value: the shapes that it
/// gives away hold copies of what they need.
class Shoulder {
 public:
  Shoulder(const BodySettings& settings, std::uint64_t seed);

  /// Highest priority first: bones, calcification, cartilage, tear, tendons, bursa, its fat.
  std::vector<Part> Parts() const;
  /// bursa, tendon, calcification (its place, whether there is one or not), tear, joint.
  Landmarks PointsOfInterest() const;
  /// Distance to the outer surface of the deltoid and of the muscles beside it, mm.
  double FasciaDistance(const Eigen::Vector3d& p) const;

  double build() const { return build_; }  ///< Factor on all lengths that belongs to the seed.

 private:
  void AddBones(std::vector<Part>& parts) const;
  void AddCuff(std::vector<Part>& parts) const;

  ShoulderSettings shoulder_;
  double cortex_mm_;
  double build_;
  double tendon_mm_;
};

}  // namespace acus::phantom
