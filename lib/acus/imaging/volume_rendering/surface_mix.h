// The surfaces on a ray, and pieces of volume between them, front to back.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>

#include "acus/imaging/volume_rendering/fragments.h"

namespace acus::volume_rendering {

/// Passes the fragments of one ray in their order.
class SurfaceMix {
 public:
  SurfaceMix() = default;
  /// @param fragments  By rising distance.
  /// @param tool_shine  What is seen of a tool behind tissue.
  SurfaceMix(std::span<const Fragment> fragments, float tool_shine)
      : fragments_(fragments), tool_shine_(tool_shine) {}

  /// The next fragment's distance; far beyond anything if there is none.
  float next_mm() const noexcept {
    return next_ < fragments_.size() ? fragments_[next_].distance_mm : 1e30F;
  }

  /// All fragments up to a distance. @param passing  Light that gets through so far.
  void Pass(float to_mm, float& passing) noexcept {
    for (; next_ < fragments_.size() && fragments_[next_].distance_mm <= to_mm; ++next_) {
      Take(fragments_[next_], passing);
    }
  }

  /// A projection of the whole ray: behind all fragments but an opaque one, see Projection.
  /// @return the weight of its colour.
  float Cover(float opacity, float& passing) noexcept {
    for (; next_ < fragments_.size() && fragments_[next_].opacity < 1.0F; ++next_) {
      Take(fragments_[next_], passing);
    }
    const float weight = passing * opacity;
    passing *= 1.0F - opacity;
    return weight;
  }

  /// Volume of one extinction, and the fragments within. @return the weight of the volume's colour.
  float Absorb(float extinction_per_mm, float from_mm, float to_mm, float& passing) noexcept {
    Pass(from_mm, passing);
    float weight = 0.0F;
    const auto absorb = [&](float length_mm) {
      const float opacity = 1.0F - std::exp(-extinction_per_mm * length_mm);
      weight += passing * opacity;
      passing *= 1.0F - opacity;
    };
    while (next_mm() <= to_mm) {
      const float at_mm = next_mm();
      absorb(at_mm - from_mm);
      from_mm = at_mm;
      Pass(at_mm, passing);
    }
    absorb(to_mm - from_mm);
    return weight;
  }

  /// Lays the surfaces over or into what the volume gave; all fragments have passed.
  void Finish(Eigen::Array3f& colour, float& opacity) const noexcept {
    colour += colour_;
    if (shine_weight_ > 0.0F) {
      colour += shine_weight_ * (shine_colour_ - colour);
      opacity += shine_weight_ * (1.0F - opacity);
    }
  }

 private:
  void Take(const Fragment& fragment, float& passing) noexcept {
    const float weight = passing * fragment.opacity;
    const float shine = tool_shine_ * fragment.opacity;
    if (fragment.is_tool && weight < shine && shine_weight_ == 0.0F) {
      shine_weight_ = shine - weight;
      shine_colour_ = fragment.colour;
    }
    colour_ += weight * fragment.colour;
    passing *= 1.0F - fragment.opacity;
  }

  std::span<const Fragment> fragments_;
  std::size_t next_ = 0;
  float tool_shine_ = 0.0F;
  Eigen::Array3f colour_ = Eigen::Array3f::Zero();  ///< Weighted by opacity.
  float shine_weight_ = 0.0F;
  Eigen::Array3f shine_colour_ = Eigen::Array3f::Zero();
};

}  // namespace acus::volume_rendering
