// A patient made of labelled closed surfaces, without any CT: from a list of files to a label map.
//
// Why a label map: every level of image, force and tissue reads volumes already, so that all of
// them work unchanged, and deformation warps it as it warps a CT. The price is the position of
// interfaces, half a voxel at most, and memory. Images of one model can follow the triangles
// themselves (imaging/tracing): docs/models/surfaces.md compares both.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/mesh/closed_surface.h"
#include "acus/data/volume/volume.h"

namespace acus::segmentation {

/// One closed surface and what is inside it.
struct TissueSurface {
  std::filesystem::path file;  ///< Any format of mesh/surface_io.h.
  std::string tissue;
  volume::Label label = 0;
  int priority =
      0;            ///< Where surfaces overlap the highest wins, among equals the last of the list.
  double hu = 0.0;  ///< For levels that read a CT.
  Eigen::Affine3d ct_from_surface = Eigen::Affine3d::Identity();
};

/// As in configs/schema/acus-surface-scene.schema.json, where the ranges and defaults are.
struct SurfaceScene {
  std::filesystem::path file;
  std::vector<TissueSurface> surfaces;
  double spacing_mm = 0.5;  ///< Of the cubic voxels.
};

/// Reads an acus-surface-scene/1 file, or the spatial models of a PLUS configuration (*.xml): those
/// in the frame of its ReferenceCoordinateFrame, later ones on top. Paths are relative to the file.
/// @throws InputError listing all problems; if a file is missing or a tissue has two HU.
SurfaceScene ReadSurfaceScene(const std::filesystem::path& path);

/// The numbers of the scene's surfaces, so that where they overlap the last one counts.
std::vector<std::size_t> RisingOrder(const SurfaceScene& scene);

/// A surface of the list, in LPS, mm.
struct ClosedSurface {
  mesh::Surface surface;
  mesh::Winding winding;
};

/// Reads all surfaces of the scene, in its order.
/// @throws InputError naming the file if a surface is open or unreadable.
std::vector<ClosedSurface> ReadClosedSurfaces(const SurfaceScene& scene, const RunContext& context);

/// The label map of the scene: a voxel has the label of the surface that its centre is inside of.
/// Deterministic with any number of threads.
/// @param surfaces  As ReadClosedSurfaces gives them.
/// @throws InputError if there would be more than 4e8 voxels.
volume::LabelMap LabelsOfSurfaces(const SurfaceScene& scene,
                                  const std::vector<ClosedSurface>& surfaces,
                                  const RunContext& context);

/// The same, reading the surfaces.
volume::LabelMap LabelsOfSurfaces(const SurfaceScene& scene, const RunContext& context);

/// A CT of constant HU in each tissue, -1000 outside: for levels that read no labels.
volume::CtVolume CtOfLabels(const SurfaceScene& scene, const volume::LabelMap& labels);

}  // namespace acus::segmentation
