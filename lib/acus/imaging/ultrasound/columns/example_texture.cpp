#include "acus/imaging/ultrasound/columns/example_texture.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "acus/imaging/ultrasound/speckle/place_hash.h"

namespace acus::ultrasound {
namespace {

constexpr double kEdgeOfExample = 0.4;  ///< Edge of the triangles; patches are twice as long.
constexpr double kRowsPerEdge = 0.5 * std::numbers::sqrt3;  // Height of a triangle over its edge.
/// Correlation length of layers blended linearly, over their distance: the lag at which the mean of
/// w(x) . w(x + lag) over x, with w the weights of the layers at unit length, is 1/e.
constexpr double kLengthOfLayer = 0.90017;

float Fraction(std::uint32_t hash) {
  return static_cast<float>(hash >> 8) * 0x1p-24F;
}

}  // namespace

TextureLayers::TextureLayers(TextureExample example, double third_mm, std::uint32_t seed)
    : example_(std::move(example)), seed_(seed) {
  const double along_mm = example_.length_mm() - example_.mm_per_px();
  const double across_mm = example_.breadth_mm() - example_.mm_per_px();
  tiles_per_mm_along_ = static_cast<float>(1.0 / (kEdgeOfExample * along_mm));
  tiles_per_mm_across_ = static_cast<float>(kRowsPerEdge / (kEdgeOfExample * across_mm));
  layers_per_mm_ = static_cast<float>(kLengthOfLayer / third_mm);
  room_along_mm_ = static_cast<float>(2.0 * along_mm);
  room_across_mm_ = static_cast<float>(2.0 * across_mm);
}

/// The example around the vertex (i, j), which a random place of it is laid on.
/// @param along, across  From the vertex, in edges of triangles; within 1 and kRowsPerEdge.
float TextureLayers::PatchAt(float along, float across, int i, int j, int layer) const noexcept {
  const float middle_along = Fraction(HashOfPlace(i, j, layer, seed_)) * room_along_mm_;
  const float middle_across =
      Fraction(HashOfPlace(i, j, layer, seed_ ^ 0x5bd1e995U)) * room_across_mm_;
  return example_.GaussianAt(middle_along + along / tiles_per_mm_along_,
                             middle_across + across / tiles_per_mm_across_);
}

/// Three patches, by their weights in the triangle around the place.
float TextureLayers::LayerAt(float along, float across, int layer) const noexcept {
  // Skewed, so that the triangles are halves of unit squares.
  const float skewed_across = across * static_cast<float>(1.0 / kRowsPerEdge);
  const float skewed_along = along - 0.5F * skewed_across;
  const float low_along = std::floor(skewed_along);
  const float low_across = std::floor(skewed_across);
  const int i = static_cast<int>(low_along);
  const int j = static_cast<int>(low_across);
  const float u = skewed_along - low_along;
  const float v = skewed_across - low_across;
  const auto patch = [&](int up_i, int up_j) {
    const float at_across =
        (low_across + static_cast<float>(up_j)) * static_cast<float>(kRowsPerEdge);
    const float at_along =
        low_along + static_cast<float>(up_i) + 0.5F * (low_across + static_cast<float>(up_j));
    return PatchAt(along - at_along, across - at_across, i + up_i, j + up_j, layer);
  };
  const bool lower = u + v < 1.0F;
  const float w0 = lower ? 1.0F - u - v : u + v - 1.0F;
  const float w1 = lower ? u : 1.0F - u;  // Of (1, 0), or (0, 1).
  const float w2 = lower ? v : 1.0F - v;
  const float sum = w0 * (lower ? patch(0, 0) : patch(1, 1)) +
                    w1 * (lower ? patch(1, 0) : patch(0, 1)) +
                    w2 * (lower ? patch(0, 1) : patch(1, 0));
  return sum / std::sqrt(w0 * w0 + w1 * w1 + w2 * w2);
}

float TextureLayers::GaussianAt(const Eigen::Vector3f& place_mm) const noexcept {
  const float along = place_mm[0] * tiles_per_mm_along_;
  const float across = place_mm[1] * tiles_per_mm_across_;
  const float third = place_mm[2] * layers_per_mm_;
  const float low = std::floor(third);
  const float part = third - low;
  const int layer = static_cast<int>(low);
  const float sum =
      (1.0F - part) * LayerAt(along, across, layer) + part * LayerAt(along, across, layer + 1);
  return sum / std::sqrt((1.0F - part) * (1.0F - part) + part * part);
}

ExampleTexture::ExampleTexture(const TextureExample& along,
                               const std::optional<TextureExample>& across, std::uint32_t seed)
    : along_(along, along.across_mm(), seed) {
  if (across) across_.emplace(*across, along.along_mm(), seed ^ 0x1b873593U);
}

float ExampleTexture::GreyAt(const Eigen::Vector3f& place_mm, float share_across) const noexcept {
  if (!across_ || share_across <= 0.0F) {
    return along_.example().GreyOf(along_.GaussianAt(place_mm));
  }
  const Eigen::Vector3f turned_mm(place_mm[1], place_mm[2], place_mm[0]);
  if (share_across >= 1.0F) return across_->example().GreyOf(across_->GaussianAt(turned_mm));
  const float share_along = 1.0F - share_across;
  const float gaussian =
      (share_along * along_.GaussianAt(place_mm) + share_across * across_->GaussianAt(turned_mm)) /
      std::sqrt(share_along * share_along + share_across * share_across);
  return share_along * along_.example().GreyOf(gaussian) +
         share_across * across_->example().GreyOf(gaussian);
}

float ExampleTexture::Mean(float share_across) const noexcept {
  const auto along = static_cast<float>(along_.example().mean());
  if (!across_) return along;
  return along + share_across * (static_cast<float>(across_->example().mean()) - along);
}

}  // namespace acus::ultrasound
