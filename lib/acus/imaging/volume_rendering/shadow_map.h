// Shadows that tools throw on the patient.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace acus::volume_rendering {

/// How near the lamp the tools are, seen from it: parallel light.
class ShadowMap {
 public:
  static constexpr int kSize = 512;
  /// Not in one's own shadow.
  static constexpr float kClearMm = 1.0F;

  /// Forgets everything.
  /// @param box  Of what throws shadows.
  void Begin(const Eigen::Vector3f& to_lamp, const Eigen::AlignedBox3f& box_mm);
  void Add(const Eigen::Matrix3Xf& nodes_mm, const Eigen::Matrix3Xi& triangles);

  /// 1 in the light, 0 behind a tool; soft at the edge.
  float LitAt(const Eigen::Vector3f& place_mm) const noexcept;

  /// For shaders. z runs towards the lamp.
  const Eigen::Matrix3f& lamp_from_ct() const { return lamp_from_ct_; }
  /// Where the middle of cell (0, 0) is, and how far cells are apart.
  const Eigen::Vector2f& low_mm() const { return low_mm_; }
  float mm_per_cell() const { return mm_per_cell_; }
  /// Height of the tool nearest to the lamp, along z; kSize x kSize cells, x fastest.
  const std::vector<float>& height_mm() const { return height_mm_; }

 private:
  Eigen::Matrix3f lamp_from_ct_ = Eigen::Matrix3f::Identity();
  Eigen::Vector2f low_mm_ = Eigen::Vector2f::Zero();
  float mm_per_cell_ = 1.0F;
  std::vector<float> height_mm_;
};

}  // namespace acus::volume_rendering
