// Triangle surfaces and tetrahedral meshes on disk.
#pragma once

#include <filesystem>

#include "acus/data/mesh/surface.h"
#include "acus/data/mesh/tetra_mesh.h"

namespace acus::mesh {

/// Reads .stl (binary or text), .obj, .ply (text or binary) or .vtp, by extension; coordinates are
/// taken as LPS mm, as they stand. Polygons are cut into triangles. The corners of an STL file that
/// lie at exactly the same place become one node; nothing else is repaired: see surface_check.h.
/// @throws InputError if the extension is unknown or the file is missing, empty, cut off or broken.
Surface ReadSurface(const std::filesystem::path& path);

/// Writes the same formats (STL, PLY and VTP binary), atomically. STL holds single precision.
/// @throws InputError if the extension is unknown or the file cannot be written.
void WriteSurface(const std::filesystem::path& path, const Surface& surface);

/// Writes a .vtu that ParaView opens: cell data `tissue` (label), point data `fixed` (0 or 1).
/// @throws InputError if the extension is not .vtu or the file cannot be written.
void WriteTetraMesh(const std::filesystem::path& path, const TetraMesh& mesh);

/// Reads what WriteTetraMesh wrote, or any .vtu of tetrahedra; without `tissue` the mesh has none,
/// without `fixed` no node is. @throws InputError if the file is broken, has cells that are not
/// tetrahedra, or a tetrahedron without positive volume.
TetraMesh ReadTetraMesh(const std::filesystem::path& path);

}  // namespace acus::mesh
