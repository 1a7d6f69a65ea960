#include "acus/patient/meshing/surface_mesher.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "acus/data/mesh/closed_surface.h"
#include "acus/data/mesh/quality.h"
#include "acus/data/mesh/surface_check.h"
#include "acus/data/mesh/surface_edges.h"
#include "acus/data/mesh/triangle_intersection.h"
#include "acus/patient/meshing/improve.h"
#include "acus/patient/meshing/label_mesher.h"
#include "acus/patient/meshing/surface_voxels.h"

namespace acus::meshing {
namespace {

/// Largest gap that a repair closes by joining nodes, as shares of the surface's diagonal.
constexpr double kGapShares[] = {1e-6, 1e-5, 1e-4, 1e-3};
constexpr double kSameVolume = 1e-6;  ///< Of a surface and the tetrahedra in it, relative.
constexpr std::size_t kMostCuts = 10'000'000;

double DiagonalMm(const mesh::Surface& surface) {
  return (surface.nodes_mm.rowwise().maxCoeff() - surface.nodes_mm.rowwise().minCoeff()).norm();
}

/// A surface that can be filled: as it is, or by all that its shells enclose.
struct Sound {
  mesh::Surface surface;
  bool is_union = false;  ///< Its shells overlap: only the boundary of all together counts.
};

[[noreturn]] void Refuse(const mesh::SurfaceReport& report, const std::string& label,
                         bool was_repaired) {
  std::string problems;
  for (const std::string& sentence : report.Sentences()) problems += "\n  " + sentence;
  throw InputError(Message(label, ": cannot be filled with tetrahedra:", problems, "\n  try: ",
                           was_repaired ? ""
                                        : "--repair, which closes cracks and fills the union "
                                          "of overlapping shells; or ",
                           "repair these places in a surface editor, or mesh the label map that "
                           "the surface was made from"));
}

/// Joins nodes over wider and wider gaps until the surface is closed without filling a hole.
/// Nothing if it never is.
std::optional<mesh::Repair> WithoutCracks(const mesh::Surface& surface) {
  for (const double share : kGapShares) {
    mesh::Repair repair = mesh::RepairSurface(surface, {.weld_share = share, .longest_hole = 0});
    if (!mesh::CheckSurface(repair.surface).is_closed()) continue;
    if (share > kGapShares[0]) {
      repair.done.push_back(Message("cracks of up to ", share * DiagonalMm(surface), " mm closed"));
    }
    return repair;
  }
  return {};
}

/// Turns the shells outwards that cut another one. One that faces inwards and cuts none is a
/// cavity.
void FaceCuttingShellsOutwards(mesh::Surface& surface) {
  const Eigen::Index count = surface.triangles.cols();
  mesh::Groups shells(count);
  mesh::ForEachEdge(mesh::SortedHalfEdges(surface.triangles),
                    [&](const mesh::HalfEdge* edge, std::size_t n) {
                      for (std::size_t i = 1; i < n; ++i)
                        shells.Join(edge[0].triangle, edge[i].triangle);
                    });
  std::map<int, double> volume_mm3;  // Volume by shell, of shells that cut another one.
  for (const auto& [a, b] : mesh::IntersectingPairs(surface, kMostCuts)) {
    if (shells.Find(a) != shells.Find(b))
      volume_mm3[shells.Find(a)] = volume_mm3[shells.Find(b)] = 0;
  }
  for (int t = 0; t < count; ++t) {
    const auto shell = volume_mm3.find(shells.Find(t));
    if (shell == volume_mm3.end()) continue;
    const Eigen::Vector3d a = surface.nodes_mm.col(surface.triangles(0, t));
    const Eigen::Vector3d b = surface.nodes_mm.col(surface.triangles(1, t));
    shell->second += a.dot(b.cross(surface.nodes_mm.col(surface.triangles(2, t)))) / 6.0;
  }
  for (int t = 0; t < count; ++t) {
    const auto shell = volume_mm3.find(shells.Find(t));
    if (shell != volume_mm3.end() && shell->second < 0.0)
      std::swap(surface.triangles(1, t), surface.triangles(2, t));
  }
}

Sound Mended(const mesh::Surface& surface, const std::string& label, bool may_repair,
             SurfaceMesh& out, const RunContext& context) {
  std::optional<mesh::Repair> closed;
  if (may_repair && surface.nodes_mm.cols() > 0) closed = WithoutCracks(surface);
  mesh::Repair repair = closed ? *std::move(closed) : mesh::RepairSurface(surface);
  const mesh::SurfaceReport report = mesh::CheckSurface(repair.surface);
  Sound sound;
  if (!report.is_fit_for_meshing()) {
    const bool has_inside = report.num_triangles > 0 && report.is_closed() &&
                            report.is_oriented() &&
                            mesh::CheckClosed(repair.surface, label) == mesh::Winding::kOriented;
    if (!may_repair || !has_inside) Refuse(report, label, may_repair);
    sound.is_union = true;
    FaceCuttingShellsOutwards(repair.surface);
    repair.done.push_back(Message(report.intersections.count,
                                  " pair(s) of triangles that cut each "
                                  "other: the union of ",
                                  report.num_components, " shell(s) is filled"));
  }
  ACUS_REQUIRE(std::abs(report.volume_mm3) > 0.0, label, ": encloses no volume");
  for (const std::string& sentence : repair.done) context.Warn(Message(label, ": ", sentence));
  out.repairs = repair.done;
  sound.surface = std::move(repair.surface);
  return sound;
}

void Copy(const TetraEditor& editor, const SurfaceMeshSettings& settings, mesh::TetraMesh& out) {
  std::vector<int> number(editor.num_nodes(), -1);
  std::vector<int> kept;
  for (int n = 0; n < editor.num_nodes(); ++n) {
    if (editor.star(n).empty()) continue;
    number[n] = static_cast<int>(kept.size());
    kept.push_back(n);
  }
  out.nodes_mm.resize(3, static_cast<Eigen::Index>(kept.size()));
  for (std::size_t n = 0; n < kept.size(); ++n) out.nodes_mm.col(n) = editor.node(kept[n]);
  std::vector<int> corners;
  for (int t = 0; t < editor.num_slots(); ++t) {
    if (!editor.is_alive(t)) continue;
    for (const int n : editor.tetrahedron(t)) corners.push_back(number[n]);
  }
  out.tetrahedra = Eigen::Map<const Eigen::Matrix4Xi>(
      corners.data(), 4, static_cast<Eigen::Index>(corners.size() / 4));
  out.tissue.assign(corners.size() / 4, settings.tissue);
  out.fixed_nodes.assign(kept.size(), settings.is_fixed ? 1 : 0);
}

double MeshMl(const mesh::TetraMesh& mesh) {
  double ml = 0.0;
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    ml += mesh::VolumeMm3(mesh::CornersOf(mesh, t)) / 1000.0;
  }
  return ml;
}

/// Fills the surface without moving it. False if that cannot be done well enough.
bool Fill(const mesh::Surface& sound, const SurfaceMeshSettings& settings, SurfaceMesh& out,
          std::string& reason, const RunContext& context) {
  try {
    const FilledSurface filled = FillSurface(sound, settings.tetgen, context);
    TetraEditor editor(filled.nodes_mm, filled.tetrahedra);
    for (int t = 0; t < editor.num_slots(); ++t) editor.set_material(t, 1);
    ImproveSettings improve;
    improve.goal_deg = std::max(improve.goal_deg, settings.min_dihedral_deg + 2.0);
    const double least_deg = Improve(editor, nullptr, improve, context);
    Copy(editor, settings, out.mesh);
    reason =
        Message("its triangles allow a smallest dihedral angle of ", least_deg, " degrees only");
    return least_deg >= settings.min_dihedral_deg;
  } catch (const NoAnswerError& error) {
    reason = error.what();
    return false;
  }
}

void Remesh(const mesh::Surface& sound, const SurfaceMeshSettings& settings, SurfaceMesh& out,
            const RunContext& context) {
  double size_mm = settings.tetgen.element_size_mm;
  if (size_mm <= 0.0) size_mm = DiagonalMm(sound) / 40.0;
  // The lattice is meant for patients: mesh at its usual scale, whatever the surface's unit is.
  const double scale = 8.0 / size_mm;
  mesh::Surface scaled = sound;
  scaled.nodes_mm *= scale;
  LabelMeshSettings lattice;
  lattice.sizes = {8.0, 8.0, 16.0, std::nullopt};
  lattice.conforming_tissues.clear();
  lattice.fixed_tissues.clear();
  lattice.smoothing_mm = 1.5;
  lattice.min_dihedral_deg = settings.min_dihedral_deg;
  LabelMesh meshed = MeshLabelMap(VoxelsInside(scaled, 2.0, settings.tissue), lattice, context);
  out.mesh = std::move(meshed.mesh);
  out.mesh.nodes_mm /= scale;
  out.surface_ml = meshed.body_map_ml / (scale * scale * scale);
  std::ranges::fill(out.mesh.fixed_nodes, settings.is_fixed ? 1 : 0);
  out.is_remeshed = true;
}

}  // namespace

SurfaceMesh MeshSurface(const mesh::Surface& surface, const std::string& label,
                        const SurfaceMeshSettings& settings, const RunContext& context) {
  SurfaceMesh out;
  context.Checkpoint("checking the surface", 0.0);
  const Sound sound = Mended(surface, label, settings.may_repair, out, context);
  std::string reason;
  if (sound.is_union) {
    Remesh(sound.surface, settings, out, context);  // Its volume is that of the voxels.
  } else {
    out.surface_ml = mesh::SignedVolumeMm3(sound.surface) / 1000.0;
    bool is_filled = Fill(sound.surface, settings, out, reason, context);
    // TetGen fills cavities, too; and of nested shells the surface's volume counts the inner twice.
    if (is_filled && std::abs(MeshMl(out.mesh) - out.surface_ml) > kSameVolume * out.surface_ml) {
      is_filled = false;
      reason = "it has shells within others";
    }
    if (!is_filled) {
      context.Warn(Message(label, ": ", reason, "; the surface is regenerated"));
      Remesh(sound.surface, settings, out, context);
    }
  }
  out.mesh_ml = MeshMl(out.mesh);
  return out;
}

}  // namespace acus::meshing
