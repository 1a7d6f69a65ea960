// What the shaders read of one image, as they have it.
#pragma once

#include <Eigen/Core>

namespace acus::graphics {

/// A matrix of 3 x 3 with columns of four numbers.
using PaddedMatrix = Eigen::Matrix<float, 4, 3>;

inline PaddedMatrix Padded(const Eigen::Matrix3f& matrix) {
  PaddedMatrix out = PaddedMatrix::Zero();
  out.topRows<3>() = matrix;
  return out;
}

/// Member by member glsl::kMoment, which says what they mean, in the layout std140: each group of
/// 16 bytes begins with a member.
struct alignas(16) MomentBlock {
  PaddedMatrix ct_from_camera = PaddedMatrix::Zero();
  Eigen::Vector3f eye_mm = Eigen::Vector3f::Zero();
  float step_mm = 1.0F;
  Eigen::Matrix4f clip_from_ct = Eigen::Matrix4f::Zero();
  Eigen::Vector2f focal_px = Eigen::Vector2f::Zero();
  Eigen::Vector2f centre_px = Eigen::Vector2f::Zero();

  PaddedMatrix index_linear = PaddedMatrix::Zero();
  Eigen::Vector3f index_offset = Eigen::Vector3f::Zero();
  float tool_shine = 0.0F;
  PaddedMatrix ct_from_grid = PaddedMatrix::Zero();
  PaddedMatrix blocks_linear = PaddedMatrix::Zero();
  Eigen::Vector3f blocks_offset = Eigen::Vector3f::Zero();
  float dark = 0.0F;

  PaddedMatrix nodes_linear = PaddedMatrix::Zero();
  Eigen::Vector3f nodes_offset = Eigen::Vector3f::Zero();
  float tolerance_mm = 0.0F;
  Eigen::Vector4f component_scale = Eigen::Vector4f::Zero();

  Eigen::Vector3f pressed_low_mm = Eigen::Vector3f::Zero();
  float pressed_spacing_mm = 1.0F;
  Eigen::Vector3f pressed_high_mm = Eigen::Vector3f::Zero();
  float surface_hu_per_mm = 0.0F;

  Eigen::Vector3f to_lamp = Eigen::Vector3f::UnitZ();
  float steepest_hu_per_mm = 0.0F;
  Eigen::Vector4f light = Eigen::Vector4f::Zero();
  PaddedMatrix lamp_from_ct = PaddedMatrix::Zero();
  Eigen::Vector2f shadow_low_mm = Eigen::Vector2f::Zero();
  float shadow_cell_mm = 1.0F;
  float shadow_clear_mm = 0.0F;

  Eigen::Vector3f background_top = Eigen::Vector3f::Zero();
  float lowest_hu = 0.0F;
  Eigen::Vector3f background_bottom = Eigen::Vector3f::Zero();
  int supersampling = 1;
  Eigen::Vector2f window_hu = Eigen::Vector2f::Zero();
  int is_maximum = 0;
  int most_nodes = 0;
  Eigen::Vector3i ct_size = Eigen::Vector3i::Ones();
  int table_count = 0;
  Eigen::Vector3i blocks_size = Eigen::Vector3i::Zero();
  int has_volume = 0;
  Eigen::Vector3i nodes_size = Eigen::Vector3i::Ones();
  int num_components = 0;
  Eigen::Vector3i pressed_size = Eigen::Vector3i::Ones();
  int is_pressed = 0;
  Eigen::Vector2i image_size = Eigen::Vector2i::Zero();
  int has_classes = 0;
  int has_shadows = 0;
  int shadow_size = 1;
  int num_cuts = 0;
  int most_iterations = 1;
  int unused = 0;
};
static_assert(sizeof(MomentBlock) % 16 == 0 && sizeof(MomentBlock) == 672);

}  // namespace acus::graphics
