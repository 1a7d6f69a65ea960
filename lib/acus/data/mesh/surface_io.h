// Triangle surfaces and tetrahedral meshes on disk.
#pragma once

#include <filesystem>

#include "acus/data/mesh/surface.h"
#include "acus/data/mesh/tetra_mesh.h"

namespace acus::mesh {

/// Reads .stl (binary or text), .obj, .ply (text or binary), .vtp or .vtk (legacy, text or binary),
/// by extension; coordinates are taken as LPS mm, as they stand, unless the file says otherwise:
/// the unit in a comment of an OBJ ("# Units: m"), RAS in the title of a .vtk of 3D Slicer.
/// Polygons are cut into triangles. The corners of an STL file that lie at exactly the same place
/// become one node; nothing else is repaired: see surface_check.h.
/// @throws InputError if the extension is unknown or the file is missing, empty, cut off or broken.
Surface ReadSurface(const std::filesystem::path& path);

/// Refuses a surface that is no part of a patient in mm: below 5 mm or above 5 m.
/// @throws InputError that names the likely unit.
void RequireSizeOfBody(const Surface& surface, const std::filesystem::path& path);

/// Writes .stl, .obj, .ply and .vtp (STL, PLY and VTP binary), atomically. STL holds single
/// precision.
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
