// Shadows that tools throw on the patient.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace acus::volume_rendering {

/// How near the lamp the tools are, seen from it: parallel light.
class ShadowMap {
 public:
  /// Forgets everything.
  /// @param box  Of what throws shadows.
  void Begin(const Eigen::Vector3f& to_lamp, const Eigen::AlignedBox3f& box_mm);
  void Add(const Eigen::Matrix3Xf& nodes_mm, const Eigen::Matrix3Xi& triangles);

  /// 1 in the light, 0 behind a tool; soft at the edge.
  float LitAt(const Eigen::Vector3f& place_mm) const noexcept;

 private:
  static constexpr int kSize = 512;

  Eigen::Matrix3f lamp_from_ct_ = Eigen::Matrix3f::Identity();  ///< z towards the lamp.
  Eigen::Vector2f low_mm_ = Eigen::Vector2f::Zero();
  float mm_per_cell_ = 1.0F;
  std::vector<float> height_mm_;  ///< Of the tool nearest to the lamp, along z.
};

}  // namespace acus::volume_rendering
