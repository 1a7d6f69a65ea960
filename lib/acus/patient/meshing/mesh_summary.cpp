#include "acus/patient/meshing/mesh_summary.h"

#include <algorithm>
#include <map>

#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"
#include "acus/data/mesh/quality.h"
#include "acus/data/volume/label_map_content.h"

namespace acus::meshing {
namespace {

std::string NameOfTissue(std::uint8_t label, const std::vector<TissueVolume>& tissues) {
  const auto known = std::ranges::find(tissues, label, &TissueVolume::label);
  if (known != tissues.end()) return known->name;
  return volume::NameOfLabel(label);
}

/// "bone 5030": nodes of elements that are held as a whole, by tissue.
std::string FixedByTissue(const mesh::TetraMesh& mesh, const std::vector<TissueVolume>& tissues,
                          const std::vector<std::string>& fixed_tissues) {
  std::map<std::string, std::vector<bool>> held;
  for (Eigen::Index t = 0; t < static_cast<Eigen::Index>(mesh.tissue.size()); ++t) {
    const auto corners = mesh.tetrahedra.col(t);
    if (!std::ranges::all_of(corners, [&](auto node) {
          return mesh.fixed_nodes[static_cast<std::size_t>(node)] != 0;
        })) {
      continue;
    }
    const std::string name = NameOfTissue(mesh.tissue[t], tissues);
    if (std::ranges::find(fixed_tissues, name) == fixed_tissues.end()) continue;
    std::vector<bool>& nodes = held[name];
    nodes.resize(mesh.fixed_nodes.size(), false);
    for (const auto node : corners) nodes[static_cast<std::size_t>(node)] = true;
  }
  std::vector<std::string> words;
  for (const auto& [name, nodes] : held)
    words.push_back(Message(name, " ", std::ranges::count(nodes, true)));
  return Joined(words);
}

std::string TissuesText(const std::vector<TissueVolume>& tissues) {
  std::vector<std::string> own, all;
  for (const TissueVolume& tissue : tissues) {
    all.push_back(tissue.name);
    if (tissue.is_conforming) own.push_back(tissue.name);
  }
  return Message("Tissues: ", Joined(all), "\nWith a surface of faces: body",
                 own.empty() ? "" : ", ", Joined(own), "\n");
}

std::string MissingText(const std::vector<TissueVolume>& tissues, const MeshLosses& losses) {
  std::vector<std::string> words;
  for (const TissueVolume& tissue : tissues) {
    if (tissue.mesh_ml > 0.0 || tissue.map_ml <= 0.0) continue;
    words.push_back(Message(tissue.name, " (", RoundedText(tissue.map_ml, 2),
                            " ml, too small for the elements)"));
  }
  if (losses.islands_ml > 0.0)
    words.push_back(RoundedText(losses.islands_ml, 2) + " ml in loose pieces of the body");
  if (losses.specks_ml > 0.0)
    words.push_back(RoundedText(losses.specks_ml, 2) + " ml in specks, now the tissue around them");
  return "Not in the mesh: " + (words.empty() ? "nothing" : Joined(words)) + "\n";
}

}  // namespace

std::string MeshText(const mesh::TetraMesh& mesh, const std::vector<TissueVolume>& tissues,
                     const std::vector<std::string>& fixed_tissues, const MeshLosses& losses) {
  const mesh::QualityReport quality = mesh::MeasureQuality(mesh);
  std::string text = Message("Mesh: ", quality.num_nodes, " nodes, ", quality.num_tetrahedra,
                             " tetrahedra, smallest dihedral angle ",
                             FixedText(quality.min_dihedral_deg, 1), " degrees\n");
  const std::string by = FixedByTissue(mesh, tissues, fixed_tissues);
  text += Message("Fixed nodes: ", quality.num_fixed_nodes, by.empty() ? "" : ", in ", by,
                  quality.num_fixed_nodes == 0 ? ": nothing holds the mesh" : "", "\n");
  if (!tissues.empty()) text += TissuesText(tissues) + MissingText(tissues, losses);
  return text;
}

void WarnWithoutFixedNodes(const mesh::TetraMesh& mesh, const std::vector<TissueVolume>& tissues,
                           const std::vector<std::string>& fixed_tissues,
                           const RunContext& context) {
  if (std::ranges::any_of(mesh.fixed_nodes, [](auto flag) { return flag != 0; })) return;
  std::vector<std::string> names;
  for (const TissueVolume& tissue : tissues) names.push_back(tissue.name);
  context.Warn(
      Message("no node of the mesh is fixed (fixed_nodes: 0): no element is ",
              fixed_tissues.empty() ? "of a tissue that is held" : Joined(fixed_tissues),
              ", so that tissue models of finite elements refuse this mesh. Try: a --config whose ",
              "\"fixed_tissues\" names a tissue that stays in place", names.empty() ? "" : ", of ",
              Joined(names), "; or find out why the label map has no bone"));
}

}  // namespace acus::meshing
