// Shadows that tools throw on the patient.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace acus::volume_rendering {

/// Where the cells of a map of shadows are, seen from the lamp: parallel light.
struct ShadowFrame {
  Eigen::Matrix3f lamp_from_ct = Eigen::Matrix3f::Identity();  ///< z runs towards the lamp.
  Eigen::Vector2f low_mm = Eigen::Vector2f::Zero();            ///< Middle of cell (0, 0).
  float mm_per_cell = 1.0F;
};

/// How near the lamp the tools are.
class ShadowMap {
 public:
  static constexpr int kSize = 512;
  /// Not in one's own shadow.
  static constexpr float kClearMm = 1.0F;

  /// @param box_mm  Of what throws shadows.
  static ShadowFrame FrameOf(const Eigen::Vector3f& to_lamp, const Eigen::AlignedBox3f& box_mm);

  /// Forgets everything.
  void Begin(const ShadowFrame& frame);
  void Add(const Eigen::Matrix3Xf& nodes_mm, const Eigen::Matrix3Xi& triangles);

  /// 1 in the light, 0 behind a tool; soft at the edge.
  float LitAt(const Eigen::Vector3f& place_mm) const noexcept;

 private:
  ShadowFrame frame_;
  /// Height of the tool nearest to the lamp, along z; kSize x kSize cells, x fastest.
  std::vector<float> height_mm_;
};

}  // namespace acus::volume_rendering
