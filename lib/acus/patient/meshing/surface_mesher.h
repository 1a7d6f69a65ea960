// Closed surface to tetrahedral mesh.
#pragma once

#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/mesh/surface.h"
#include "acus/data/mesh/tetra_mesh.h"
#include "acus/patient/meshing/tetgen_calls.h"

namespace acus::meshing {

struct SurfaceMeshSettings {
  SurfaceMeshing tetgen;
  double min_dihedral_deg = 8.0;  ///< A mesh below this is refused.
  std::uint8_t tissue = 4;        ///< Label of all tetrahedra.
  bool is_fixed = false;          ///< All nodes are held in place.
  bool may_repair = false;        ///< Cracks and overlapping shells, too: see MeshSurface.
};

struct SurfaceMesh {
  mesh::TetraMesh mesh;
  std::vector<std::string> repairs;  ///< What was repaired, as sentences; warned of, too.
  bool is_remeshed = false;  ///< The surface was made again, because its triangles are too thin.
  double surface_ml = 0.0;   ///< Volume inside the repaired surface.
  double mesh_ml = 0.0;
};

/// Repairs simple defects, fills the surface by TetGen and improves the elements inside. Where the
/// triangles of the surface themselves forbid the angle requested, or TetGen fails, the inside is
/// meshed by way of voxels (label_mesher.h): the surface is then followed to about a tenth of the
/// element size, and a warning says so.
///
/// With settings.may_repair, nodes are also joined over cracks of up to a thousandth of the
/// surface's diagonal, and shells that cut each other are replaced by their union, by way of
/// voxels: what any shell encloses is filled. A shell that faces inwards and cuts none is a cavity.
/// @param label  Names the surface in messages.
/// @throws InputError with every defect and its place, if the surface cannot be repaired.
/// @throws NoAnswerError if the smallest dihedral angle misses its limit both ways.
SurfaceMesh MeshSurface(const mesh::Surface& surface, const std::string& label,
                        const SurfaceMeshSettings& settings, const RunContext& context);

}  // namespace acus::meshing
