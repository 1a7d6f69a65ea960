#include "acus/data/mesh/surface_io.h"

#include <algorithm>
#include <cctype>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/mesh/surface_formats.h"
#include "acus/data/mesh/vtk_io.h"

namespace acus::mesh {
namespace {

std::string ExtensionOf(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

[[noreturn]] void RefuseExtension(const std::filesystem::path& path) {
  throw InputError(Message(path.string(),
                           ": a surface must be .stl, .obj, .ply, .vtp or (to be read) .vtk, not '",
                           path.extension().string(), "'"));
}

void RequireSound(const Surface& surface, const std::filesystem::path& path) {
  ACUS_REQUIRE(surface.nodes_mm.allFinite(), path.string(), ": a node to be written is not finite");
  ACUS_REQUIRE(surface.triangles.cols() > 0, path.string(), ": there is no triangle to write");
  ACUS_REQUIRE(
      surface.triangles.minCoeff() >= 0 && surface.triangles.maxCoeff() < surface.nodes_mm.cols(),
      path.string(), ": a triangle to be written names a node that does not exist");
}

void RequirePositive(const TetraMesh& mesh, const std::string& label) {
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    const Eigen::Vector3d a = mesh.nodes_mm.col(mesh.tetrahedra(0, t));
    const double six_volumes = (mesh.nodes_mm.col(mesh.tetrahedra(1, t)) - a)
                                   .dot((mesh.nodes_mm.col(mesh.tetrahedra(2, t)) - a)
                                            .cross(mesh.nodes_mm.col(mesh.tetrahedra(3, t)) - a));
    ACUS_REQUIRE(six_volumes > 0.0, label, ": tetrahedron ", t, " at (", a[0], ", ", a[1], ", ",
                 a[2], ") mm is flat or inside out; mesh again with acus-mesh");
  }
}

}  // namespace

Surface ReadSurface(const std::filesystem::path& path) {
  const std::string extension = ExtensionOf(path);
  if (extension == ".vtp") return ReadVtp(path);
  if (extension == ".vtk") return ReadLegacyVtk(path);
  if (extension == ".stl") return ParseStl(ReadTextFile(path), path.string());
  if (extension == ".obj") return ParseObj(ReadTextFile(path), path.string());
  if (extension == ".ply") return ParsePly(ReadTextFile(path), path.string());
  RefuseExtension(path);
}

void RequireSizeOfBody(const Surface& surface, const std::filesystem::path& path) {
  constexpr double kLeastMm = 5.0;
  constexpr double kLargestMm = 5000.0;
  const Eigen::Vector3d size_mm =
      surface.nodes_mm.rowwise().maxCoeff() - surface.nodes_mm.rowwise().minCoeff();
  const double diagonal_mm = size_mm.norm();
  const bool is_tiny = diagonal_mm < kLeastMm;
  ACUS_REQUIRE(!is_tiny && diagonal_mm <= kLargestMm, path.string(), ": the surface is ",
               size_mm[0], " x ", size_mm[1], " x ", size_mm[2], " mm: it is probably in ",
               is_tiny ? "metres" : "micrometres",
               ". Coordinates are needed in mm; --as-it-is takes them as they are");
}

void WriteSurface(const std::filesystem::path& path, const Surface& surface) {
  RequireSound(surface, path);
  const std::string extension = ExtensionOf(path);
  if (extension == ".vtp") {
    AtomicFile file(path);
    WriteVtp(file.path(), surface);
    file.Commit();
  } else if (extension == ".stl") {
    WriteTextFile(path, FormatStl(surface));
  } else if (extension == ".obj") {
    WriteTextFile(path, FormatObj(surface));
  } else if (extension == ".ply") {
    WriteTextFile(path, FormatPly(surface));
  } else {
    RefuseExtension(path);
  }
}

void WriteTetraMesh(const std::filesystem::path& path, const TetraMesh& mesh) {
  ACUS_REQUIRE(ExtensionOf(path) == ".vtu", path.string(), ": a tetrahedral mesh must be .vtu");
  ACUS_REQUIRE(mesh.nodes_mm.allFinite(), path.string(), ": a node to be written is not finite");
  AtomicFile file(path);
  WriteVtu(file.path(), mesh);
  file.Commit();
}

TetraMesh ReadTetraMesh(const std::filesystem::path& path) {
  ACUS_REQUIRE(ExtensionOf(path) == ".vtu", path.string(), ": a tetrahedral mesh must be .vtu");
  TetraMesh mesh = ReadVtu(path);
  RequirePositive(mesh, path.string());
  return mesh;
}

}  // namespace acus::mesh
