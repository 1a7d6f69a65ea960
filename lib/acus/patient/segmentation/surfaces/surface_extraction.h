// Closed surfaces of tissues.
#pragma once

#include "acus/data/mesh/surface.h"
#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {

struct SurfaceOptions {
  double grid_mm = 2.0;           ///< Detail: the mask is averaged onto a grid no finer than that.
  int smoothing_iterations = 15;  ///< Of the windowed sinc filter; 0 = none.
  double smoothing_pass_band = 0.1;  ///< In (0, 2]; lower is smoother. Does not shrink.
  int target_triangles = 60000;  ///< Decimated to about that many; more where topology needs it.
  double min_part_ml = 1.0;      ///< Smaller parts are omitted, and holes within are filled.
};

/// The surface of a mask, in LPS mm: closed (also where the border of the volume cuts the mask),
/// triangles counter-clockwise seen from outside, smoothed without shrinking (Taubin, Zhang, Golub
/// 1996, windowed sinc) and decimated without changing its topology.
/// @throws InputError if no part of the mask is as large as min_part_ml.
mesh::Surface ExtractSurface(const Mask& mask, const SurfaceOptions& options, int num_threads);

}  // namespace acus::segmentation
