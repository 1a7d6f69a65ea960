// Lines in a volume, bright or dark, of several widths.
#pragma once

#include <span>

#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {

/// The image, blurred by a Gaussian of `sigma_mm`; values at the border continue beyond it.
volume::Grid<float> Blurred(const volume::Grid<float>& image, double sigma_mm, int num_threads);

/// How much each voxel of `where` lies on a line (0 elsewhere), in the unit of the image:
///   r = -e sigma^2 lambda_2,
/// with the middle eigenvalue lambda_2 of the Hessian of the image blurred by sigma. It is > 0 on
/// bright lines, < 0 on dark ones, and 0 on sheets and steps. On the axis of a straight cylinder of
/// radius R that is c brighter than its surroundings, r = c e x exp(-x) with x = R^2 / (2 sigma^2),
/// which is c for sigma = R / sqrt(2). Lorenz et al. 1997, doi:10.1007/BFb0029242; Sato et al.
/// 1998, doi:10.1016/S1361-8415(98)80009-1.
volume::Grid<float> LineResponse(const volume::Grid<float>& image, const Mask& where,
                                 double sigma_mm, int num_threads);

}  // namespace acus::segmentation
