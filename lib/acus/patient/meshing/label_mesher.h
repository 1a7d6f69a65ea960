// Label map to tetrahedral mesh.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/mesh/tetra_mesh.h"
#include "acus/data/volume/volume.h"
#include "acus/patient/meshing/lattice_points.h"
#include "acus/patient/meshing/surface_distance.h"

namespace acus::meshing {

struct LabelMeshSettings {
  ElementSizes sizes;  ///< The corridor in CT space, LPS.
  /// Beside the body's surface; "all" stands for every tissue that occurs.
  std::vector<std::string> conforming_tissues = {"bone"};
  std::vector<std::string> except_tissues;                   ///< Not these of them.
  std::vector<std::string> fixed_tissues = {"bone", "cut"};  ///< Their nodes are held.
  double smoothing_mm = 1.0;       ///< Standard deviation; takes the voxels' steps away.
  double min_dihedral_deg = 8.0;   ///< A mesh below this is refused.
  double volume_tolerance = 0.03;  ///< Allowed relative error of the conforming tissues' volumes.
  double min_island_share = 0.01;  ///< Pieces of the body below this share of it are omitted.
  std::size_t max_nodes = 2'000'000;
  /// With sizes.finest_mm: elements shrink at the worst places until there are about so many.
  std::size_t wanted_nodes = 60'000;
};

struct TissueVolume {
  std::uint8_t label = 0;
  std::string name;
  double map_ml = 0.0;
  double target_ml = 0.0;  ///< Without what no element can hold, and with what goes to it.
  double mesh_ml = 0.0;
  bool is_conforming = false;  ///< Its surface is made of faces of the mesh.
  std::optional<SurfaceDistance> surface = std::nullopt;
};

struct LabelMesh {
  mesh::TetraMesh mesh;
  double body_map_ml = 0.0;
  double body_target_ml = 0.0;  ///< Without loose islands and specks.
  double body_mesh_ml = 0.0;
  std::vector<TissueVolume> tissues;  ///< By label.
  std::optional<SurfaceDistance> body_surface = std::nullopt;
  double dropped_ml = 0.0;  ///< Islands omitted.
  double specks_ml = 0.0;   ///< In pieces smaller than the elements; their surroundings got them.
  ElementSizes sizes;       ///< As used: finer than requested where a limit was missed.
};

/// Meshes the body (all labels but 0), with faces along its surface and along the surfaces of the
/// conforming tissues, shared by both sides; the other tissues are distinguished element by
/// element. Conforming tissues that such elements cannot hold (thin ones, whose volume misses the
/// limit) are distinguished element by element instead, with a warning. Otherwise a mesh that
/// misses a limit is made again with finer elements, at most four times and only up to about
/// 600,000 nodes. Method and limits: docs/models/mesh.md.
/// @throws InputError if the map holds no body, or a setting is out of range.
/// @throws NoAnswerError if the smallest dihedral angle or the body's volume misses its limit.
LabelMesh MeshLabelMap(const volume::LabelMap& labels, const LabelMeshSettings& settings,
                       const RunContext& context);

/// Measures how far the surfaces of the body and of each tissue are from the label map's.
/// @param labels  What the mesh was made from.
void AddSurfaceDistances(const volume::LabelMap& labels, int num_threads, LabelMesh& mesh);

}  // namespace acus::meshing
