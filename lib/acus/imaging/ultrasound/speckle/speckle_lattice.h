// The lattice that the scatterers of speckle are drawn on, fixed to the tissue at rest.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "acus/data/volume/geometry.h"

namespace acus::ultrasound {

/// The lattice of the speckle is turned against all axes of the volume, so that no row of samples
/// runs along its points, and sheared so that its tetrahedra are as long in all directions (the
/// body-centred lattice of simplex noise). Another seed turns it otherwise: other scatterers, at no
/// cost per sample.
Eigen::Matrix3d SpeckleLatticeFromIndex(const volume::Geometry& geometry, double grain_mm,
                                        std::uint64_t seed);

}  // namespace acus::ultrasound
