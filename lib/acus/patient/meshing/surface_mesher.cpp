#include "acus/patient/meshing/surface_mesher.h"

#include <algorithm>
#include <cmath>

#include "acus/data/mesh/quality.h"
#include "acus/data/mesh/surface_check.h"
#include "acus/patient/meshing/improve.h"
#include "acus/patient/meshing/label_mesher.h"
#include "acus/patient/meshing/surface_voxels.h"

namespace acus::meshing {
namespace {

mesh::Surface Mended(const mesh::Surface& surface, const std::string& label, SurfaceMesh& out,
                     const RunContext& context) {
  mesh::Repair repair = mesh::RepairSurface(surface);
  const mesh::SurfaceReport report = mesh::CheckSurface(repair.surface);
  if (!report.is_fit_for_meshing()) {
    std::string problems;
    for (const std::string& sentence : report.Sentences()) problems += "\n  " + sentence;
    throw InputError(Message(label, ": cannot be filled with tetrahedra:", problems,
                             "\n  try: repair these places in a surface editor, or mesh the label "
                             "map that the surface was made from"));
  }
  ACUS_REQUIRE(std::abs(report.volume_mm3) > 0.0, label, ": encloses no volume");
  for (const std::string& sentence : repair.done) context.Warn(Message(label, ": ", sentence));
  out.repairs = repair.done;
  return std::move(repair.surface);
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
  if (size_mm <= 0.0) {
    size_mm =
        (sound.nodes_mm.rowwise().maxCoeff() - sound.nodes_mm.rowwise().minCoeff()).norm() / 40.0;
  }
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
  out.mesh = MeshLabelMap(VoxelsInside(scaled, 2.0, settings.tissue), lattice, context).mesh;
  out.mesh.nodes_mm /= scale;
  std::ranges::fill(out.mesh.fixed_nodes, settings.is_fixed ? 1 : 0);
  out.is_remeshed = true;
}

}  // namespace

SurfaceMesh MeshSurface(const mesh::Surface& surface, const std::string& label,
                        const SurfaceMeshSettings& settings, const RunContext& context) {
  SurfaceMesh out;
  context.Checkpoint("checking the surface", 0.0);
  const mesh::Surface sound = Mended(surface, label, out, context);
  std::string reason;
  if (!Fill(sound, settings, out, reason, context)) {
    context.Warn(Message(label, ": ", reason, "; the surface is regenerated"));
    Remesh(sound, settings, out, context);
  }
  out.surface_ml = mesh::SignedVolumeMm3(sound) / 1000.0;
  for (Eigen::Index t = 0; t < out.mesh.tetrahedra.cols(); ++t) {
    out.mesh_ml += mesh::VolumeMm3(mesh::CornersOf(out.mesh, t)) / 1000.0;
  }
  return out;
}

}  // namespace acus::meshing
