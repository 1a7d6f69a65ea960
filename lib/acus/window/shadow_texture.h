// Shadows of needle and probe on the skin: they show the distance of the tools (Alamilla-2021,
// section V: the view for teaching).
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <vector>

#include "acus/base/math/polyline.h"
#include "acus/data/mesh/surface.h"
#include "acus/window/space_layer.h"

namespace acus::window {

/// Light from a direction falls on a surface; tools above it cast a shadow. The texture is mapped
/// onto the surface along the light, so that shadows move without a change of the surface.
class ShadowTexture {
 public:
  static constexpr int kSize = 320;

  /// @param towards_light  In CT space.
  ShadowTexture(const mesh::Surface& surface, const Eigen::Vector3d& towards_light);

  /// Texture coordinates of nodes of the surface: SpaceLayer::SetTexturePlaces.
  Eigen::Matrix2Xf PlacesOf(const Eigen::Matrix3Xd& nodes_mm) const;

  void Clear();
  /// Adds the part of the line that is outside.
  void AddLine(std::span<const Eigen::Vector3d> points_mm, double radius_mm);
  /// Adds the part of the surface that is outside.
  void AddSurface(const mesh::Surface& tool, const Eigen::Isometry3d& ct_from_tool);
  /// Softens the edges; the image is white in the light, and grey in the shade. Its opacity is
  /// `lit_opacity`, and 1 in the shade: a shadow shows on a transparent skin too.
  Texture Finish(double lit_opacity);

  /// Share of the light that is blocked at a point of the surface, 0 or 1, before Finish().
  bool IsShaded(const Eigen::Vector3d& place_mm) const;

 private:
  /// Column, row, and height towards the light in mm.
  Eigen::Vector3d InLight(const Eigen::Vector3d& place_mm) const;
  float HeightAt(double column, double row) const;

  Eigen::Matrix3d light_from_ct_;
  Eigen::Vector2d corner_mm_ = Eigen::Vector2d::Zero();
  double mm_per_px_ = 1.0;
  std::vector<float> height_mm_;  ///< Height of the surface towards the light; lowest: none.
  std::vector<std::uint8_t> shade_;
  std::vector<std::uint8_t> row_sums_;
  std::vector<std::uint8_t> rgba_;
};

}  // namespace acus::window
