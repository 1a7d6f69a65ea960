// The only door to TetGen (AGPL). It runs in a child process: it may exit, crash or not come back.
#pragma once

#include <Eigen/Dense>

#include "acus/base/core/run_context.h"
#include "acus/data/mesh/surface.h"

namespace acus::meshing {

/// Delaunay tetrahedra of a set of points: columns of point numbers, positive volume.
/// @throws NoAnswerError if TetGen fails.
Eigen::Matrix4Xi DelaunayTetrahedra(const Eigen::Matrix3Xd& points_mm, const RunContext& context);

struct SurfaceMeshing {
  double max_radius_edge_ratio = 1.4;
  double element_size_mm =
      0.0;  ///< Edge length of a regular tetrahedron of the largest volume allowed; 0: no limit.
  double time_limit_s = 60.0;
};

struct FilledSurface {
  Eigen::Matrix3Xd nodes_mm;
  Eigen::Matrix4Xi tetrahedra;
};

/// Fills a closed surface, which TetGen may divide further but does not move.
/// @pre the surface is closed and does not cut itself (mesh/surface_check.h).
/// @throws NoAnswerError if TetGen gives up, crashes or takes longer than the limit.
FilledSurface FillSurface(const mesh::Surface& surface, const SurfaceMeshing& settings,
                          const RunContext& context);

}  // namespace acus::meshing
