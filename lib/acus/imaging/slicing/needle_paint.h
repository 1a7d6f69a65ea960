// Puts a needle into sampled Hounsfield units, as the 2010 paper does with 4000 HU.
#pragma once

#include <Eigen/Geometry>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/ct_sampler.h"

namespace acus::slicing {

inline constexpr float kNeedleHu = 4000.0F;  ///< Augmented-2010, section II-C.

/// Sets the samples that the needle covers to kNeedleHu.
///
/// The part of the shaft whose surface comes within slice_thickness_mm / 2 of the plane is seen; it
/// is projected onto the plane. Its end tapers to a point over three radii. At least one sample
/// wide, so that a thin needle in a coarse image is not broken up. A bent needle is painted piece
/// by piece.
/// @throws InputError if the needle is not finite, has no direction or a negative size.
void PaintNeedle(const image::NeedleInImage& needle, const Eigen::Isometry3d& ct_from_probe,
                 double slice_thickness_mm, const acoustics::ScanGrid& grid, BeamImage& hu);

}  // namespace acus::slicing
