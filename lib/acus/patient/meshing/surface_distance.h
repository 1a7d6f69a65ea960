// How far the surfaces of a mesh lie from the boundaries in the label map that it was made from.
#pragma once

#include <vector>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/data/volume/volume.h"

namespace acus::meshing {

/// Symmetric distance between two surfaces of one tissue: A, made of the faces of its tetrahedra
/// that have another tissue or nothing on their other side, and B, made of the faces between its
/// voxels and others. Both are sampled evenly by area, and each sample's distance to the nearest
/// place of the other surface is exact; a percentile is the larger of the two directions, so that a
/// part that one surface lacks is not hidden by the other.
///
/// Voxels: the same in a frame whose axes are those of the grid, divided by the spacing. A surface
/// that is one slice off counts 1, as does one that is one pixel off within the slice.
struct SurfaceDistance {
  volume::Label label = 0;  ///< 0: the body against its outside.
  double mean_mm = 0.0;     ///< Also the larger of both directions.
  double p95_mm = 0.0;  ///< 95th-percentile Hausdorff distance. Infinite: no surface in the mesh.
  double p95_voxels = 0.0;
  std::size_t num_samples = 0;  ///< Of both directions together.
};

/// One entry for the body, then one for each label that occurs in the map, in order. Steps of the
/// voxels alone make about 0.3 voxels on a slanting surface that is followed perfectly.
/// Distances beyond 64 voxels or mm count as that.
std::vector<SurfaceDistance> MeasureSurfaceDistances(const volume::LabelMap& labels,
                                                     const mesh::TetraMesh& mesh, int num_threads);

}  // namespace acus::meshing
