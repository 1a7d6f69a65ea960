// What breath does to how dense lung looks.
#pragma once

#include <vector>

#include "acus/patient/breathing_registration/level_image.h"
#include "acus/patient/breathing_registration/sliding_grid.h"

namespace acus::breathing_registration {

/// How a reference looks in a phase: lung that grows gets less dense, lung that is compressed
/// denser. Its mass stays, so that HU + 1000 is divided by the ratio of its volumes (Yin,
/// Hoffman and Lin, Medical Physics 2009). Here the images give that ratio, not the field: mass of
/// lung in the reference by mass where the field takes it in the phase, averaged over lung nearby.
/// All but lung keeps its HU. A value; const access from any number of threads.
class LungDensity {
 public:
  /// Lung looks as it does in the reference.
  LungDensity() = default;
  /// @param reference  On the nodes of the grid, in contrast. @param phase  The same.
  LungDensity(const SlidingGrid& grid, const SlidingGrid::Field& displacement_voxels,
              const ModelImage& reference, const ModelImage& phase, int num_threads);

  struct Look {
    float contrast = 0.0F;
    float slope = 1.0F;  ///< Of it by the contrast in the reference.
  };
  /// How node n looks in the phase. @param contrast  In the reference.
  Look At(int n, float contrast) const noexcept;
  /// Volume in the phase by volume in the reference, in [0.5, 2]; 1 where no lung is near.
  float VolumeRatio(int n) const noexcept {
    return ratio_.empty() ? 1.0F : ratio_[static_cast<std::size_t>(n)];
  }

 private:
  std::vector<float> ratio_;  ///< Of each node; empty: 1.
};

}  // namespace acus::breathing_registration
