// Texture like an example, without end, fixed in space: each place by itself, without a seam.
//
// Heitz and Neyret 2018, High-Performance By-Example Noise using a Histogram-Preserving Blending
// Operator (Proc. ACM Comput. Graph. Interact. Tech. 1(2):31), in layers for the third dimension.
// Equations: docs/models/ultrasound_alamilla.md, "Textures from example images".
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "acus/imaging/ultrasound/columns/texture_example.h"

namespace acus::ultrasound {

/// Space filled with layers of patches of one example. Const after construction.
class TextureLayers {
 public:
  /// @param third_mm  Correlation length across the layers, > 0.
  TextureLayers(TextureExample example, double third_mm, std::uint32_t seed);

  /// Standard normal number, correlated as the example. @param place_mm  Along and across the
  /// example, and across the layers.
  float GaussianAt(const Eigen::Vector3f& place_mm) const noexcept;
  const TextureExample& example() const { return example_; }

 private:
  float LayerAt(float along, float across, int layer) const noexcept;
  float PatchAt(float along, float across, int i, int j, int layer) const noexcept;

  TextureExample example_;
  float tiles_per_mm_along_;  ///< One over the edges of the triangles.
  float tiles_per_mm_across_;
  float layers_per_mm_;
  float room_along_mm_;  ///< In which the middle of a patch is drawn: twice the example.
  float room_across_mm_;
  std::uint32_t seed_;
};

/// Texture of a tissue from one example along its fibres and, if there is one, another across them.
class ExampleTexture {
 public:
  ExampleTexture(const TextureExample& along, const std::optional<TextureExample>& across,
                 std::uint32_t seed);

  /// Grey, 0 to 1. @param place_mm  Along the fibres, and twice across.
  /// @param share_across  0: the image contains the fibres; 1: it lies across them.
  float GreyAt(const Eigen::Vector3f& place_mm, float share_across) const noexcept;

  /// Mean of the greys, for this share.
  float Mean(float share_across) const noexcept;
  /// Whether the image's direction matters.
  bool has_across() const { return across_.has_value(); }

 private:
  TextureLayers along_;
  std::optional<TextureLayers> across_;
};

}  // namespace acus::ultrasound
