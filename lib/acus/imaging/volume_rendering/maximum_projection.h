// Maximum intensity projection: a ray shows the largest value that it meets.
#pragma once

#include <algorithm>

#include "acus/imaging/volume_rendering/transfer_function.h"

namespace acus::volume_rendering {

/// What a ray through the volume gives.
enum class Projection {
  kEmission,  ///< Emission and absorption of the layers (Levoy 1988), lit.
  /// The largest HU of its samples, white, not lit, with the opacity that a HuWindow says. An
  /// opaque surface or tool ends the ray: what is behind has no part in it. Surfaces and tools that
  /// are not opaque lie in front of the projection, wherever they are on the ray, by their own
  /// opacity; the opaque one lies behind it, and shines through it if it is a tool.
  kMaximum,
};

/// Grey values of a maximum: transparent up to the low end, white and opaque from the high end,
/// linear between.
struct HuWindow {
  double low_hu = 100.0;  ///< Bone, and vessels with contrast agent.
  double high_hu = 1000.0;
};

/// A ray's share of white.
inline float OpacityIn(const HuWindow& window, float highest_hu) noexcept {
  const auto low = static_cast<float>(window.low_hu);
  const float share = (highest_hu - low) / (static_cast<float>(window.high_hu) - low);
  return std::clamp(share, 0.0F, 1.0F);
}

/// A transfer function that shows what a window does, and one HU more, so that values between
/// voxels may be rounded: for VisibleBlocks and HiddenCells.
/// @throws InputError if the window does not rise, or reaches out of -1024 to 3071 HU.
TransferFunction ShownIn(const HuWindow& window);

}  // namespace acus::volume_rendering
