// Puts a needle into sampled Hounsfield units, as the 2010 paper does with 4000 HU.
#pragma once

#include <Eigen/Geometry>

#include "ultrasound/ct_sampler.h"
#include "ultrasound/image.h"
#include "ultrasound/probe.h"

namespace acus::ultrasound {

inline constexpr float kNeedleHu = 4000.0F;  ///< Augmented-2010, section II-C.

/// Sets the samples that the needle covers to kNeedleHu.
///
/// The part of the shaft whose surface comes within slice_thickness_mm / 2 of the plane is seen; it
/// is projected onto the plane. Its end tapers to a point over three radii. At least one sample
/// wide, so that a thin needle in a coarse picture is not broken up. A bent needle is painted piece
/// by piece.
/// @throws InputError if the needle is not finite, has no direction or a negative size.
void PaintNeedle(const NeedleInImage& needle, const Eigen::Isometry3d& ct_from_probe,
                 double slice_thickness_mm, const ScanGrid& grid, BeamImage& hu);

}  // namespace acus::ultrasound
