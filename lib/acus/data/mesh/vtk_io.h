// VTK's formats. The only door to VTK in this module; private to surface_io.cpp.
#pragma once

#include <filesystem>
#include <string>

#include "acus/data/mesh/surface.h"
#include "acus/data/mesh/tetra_mesh.h"

namespace acus::mesh {

/// As ReadSurface and ReadTetraMesh. Reading happens in a child process: VTK may crash on, or
/// allocate far too much for, a broken file.
Surface ReadVtp(const std::filesystem::path& path);
/// Polygonal data of the legacy format (.vtk), text or binary.
Surface ReadLegacyVtk(const std::filesystem::path& path);
TetraMesh ReadVtu(const std::filesystem::path& path);

void WriteVtp(const std::filesystem::path& path, const Surface& surface);
void WriteVtu(const std::filesystem::path& path, const TetraMesh& mesh);

}  // namespace acus::mesh
