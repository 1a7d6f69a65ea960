// What sends echoes back: points in the plane of the image.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace acus::rf {

struct Scatterer {
  Eigen::Vector2d position_mm = Eigen::Vector2d::Zero();  ///< x lateral, y depth.
  double amplitude = 1.0;
};

/// A rectangle of tissue.
struct ScatteringRegion {
  Eigen::Vector2d low_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d high_mm = Eigen::Vector2d::Zero();
  double per_mm2 = 0.0;
};

/// Uniformly distributed; the number is area times density. All have the amplitude
/// 1 / sqrt(density): the echo level does not depend on the density, and speckle is fully developed
/// at fewer scatterers than if their amplitudes differed.
/// @throws InputError if the rectangle or the density is negative, or above 5 million come out.
std::vector<Scatterer> ScatterersIn(const ScatteringRegion& region, std::uint64_t seed);

}  // namespace acus::rf
