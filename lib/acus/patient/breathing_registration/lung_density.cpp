#include "acus/patient/breathing_registration/lung_density.h"

#include <algorithm>

#include "acus/base/core/parallel.h"

namespace acus::breathing_registration {
namespace {

using Eigen::Array2f;
using Eigen::Vector3f;

constexpr int kDensityChunk = 8192;
constexpr float kAir = -400.0F;        // Contrast of -1000 HU.
constexpr float kLungBelow = -225.0F;  // Contrast of -300 HU.
constexpr float kTissue = 50.0F;       // Contrast of what lung borders on.
constexpr float kPartLungBelow = 0.0F;
constexpr float kSmallestRatio = 0.5F, kLargestRatio = 2.0F;
constexpr int kAverages = 8;  // Each over a node and those beside it.

/// Calls use(n) for the nodes that hold some lung.
template <class Use>
void ForLung(const SlidingGrid& grid, const ModelImage& reference, int num_threads,
             const Use& use) {
  const int count = grid.num_nodes();
  ParallelFor((count + kDensityChunk - 1) / kDensityChunk, num_threads, [&](int c) {
    for (int n = c * kDensityChunk; n < std::min(count, (c + 1) * kDensityChunk); ++n) {
      if (reference.Voxel(grid.Voxel(n))[0] < kPartLungBelow) use(n);
    }
  });
}

/// Mass of node n in the reference and in the phase, as contrast above air; 0 unless both are lung.
Array2f MassesOf(const SlidingGrid& grid, int n, const Vector3f& u, const ModelImage& reference,
                 const ModelImage& phase) {
  const float rest = reference.Voxel(grid.Voxel(n))[0];
  if (rest >= kLungBelow) return Array2f::Zero();
  const ModelImage::Sample moved = phase.At(grid.IndexOf(n) + u);
  if (!moved.within || moved.value >= kLungBelow) return Array2f::Zero();
  return {rest - kAir, moved.value - kAir};
}

}  // namespace

LungDensity::LungDensity(const SlidingGrid& grid, const SlidingGrid::Field& displacement_voxels,
                         const ModelImage& reference, const ModelImage& phase, int num_threads)
    : ratio_(static_cast<std::size_t>(grid.num_nodes()), 1.0F) {
  std::vector<Array2f> masses(ratio_.size(), Array2f::Zero());
  ForLung(grid, reference, num_threads, [&](int n) {
    const auto i = static_cast<std::size_t>(n);
    masses[i] = MassesOf(grid, n, displacement_voxels[i], reference, phase);
  });
  for (int pass = 0; pass < kAverages; ++pass) {
    const std::vector<Array2f> before = masses;
    ForLung(grid, reference, num_threads, [&](int n) {
      Array2f sum = before[static_cast<std::size_t>(n)];
      grid.ForNodesBeside(n, [&](int m) { sum += before[static_cast<std::size_t>(m)]; });
      masses[static_cast<std::size_t>(n)] = sum / 7.0F;
    });
  }
  ForLung(grid, reference, num_threads, [&](int n) {
    const Array2f& mass = masses[static_cast<std::size_t>(n)];
    if (mass[1] < 1e-3F) return;
    ratio_[static_cast<std::size_t>(n)] =
        std::clamp(mass[0] / mass[1], kSmallestRatio, kLargestRatio);
  });
}

LungDensity::Look LungDensity::At(int n, float contrast) const noexcept {
  const float change = 1.0F / VolumeRatio(n) - 1.0F;
  if (change == 0.0F || contrast <= kAir || contrast >= kTissue) return {.contrast = contrast};
  // All of a node's mass belongs to lung up to where lung ends, none where it looks as tissue does.
  constexpr float kFall = (kAir - kLungBelow) / (kTissue - kLungBelow);
  if (contrast < kLungBelow) {
    return {.contrast = contrast + change * (contrast - kAir), .slope = 1.0F + change};
  }
  return {.contrast = contrast + change * kFall * (contrast - kTissue),
          .slope = 1.0F + change * kFall};
}

}  // namespace acus::breathing_registration
