#include "acus/physics/mechanics/elements/element_patches.h"

#include <algorithm>

#include "acus/physics/mechanics/elements/dilatation_patches.h"

namespace acus::mechanics {
namespace {

std::vector<int> Resisting(const mesh::TetraMesh& mesh, std::span<const std::uint8_t> is_left_out) {
  std::vector<int> out;
  for (int t = 0; t < mesh.tetrahedra.cols(); ++t) {
    if (!is_left_out.empty() && is_left_out[t]) continue;
    bool moves = mesh.fixed_nodes.empty();
    for (int c = 0; c < 4 && !moves; ++c) moves = !mesh.fixed_nodes[mesh.tetrahedra(c, t)];
    if (moves) out.push_back(t);
  }
  return out;
}

std::vector<int> NodesOf(const mesh::TetraMesh& mesh, const std::vector<int>& tetrahedra) {
  std::vector<int> nodes;
  for (const int t : tetrahedra) {
    for (const int node : mesh.tetrahedra.col(t)) nodes.push_back(node);
  }
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

}  // namespace

std::vector<ElementPatch> ElementPatches(const mesh::TetraMesh& mesh, ElementKind kind,
                                         std::span<const std::uint8_t> is_left_out) {
  const std::vector<int> resisting = Resisting(mesh, is_left_out);
  std::vector<ElementPatch> patches;
  if (kind == ElementKind::kAveragedDilatation) {
    for (std::vector<int>& tetrahedra : DilatationPatches(mesh, resisting)) {
      patches.push_back({std::move(tetrahedra), {}});
    }
  } else {
    patches.reserve(resisting.size());
    for (const int t : resisting) patches.push_back({{t}, {}});
  }
  for (ElementPatch& patch : patches) patch.nodes = NodesOf(mesh, patch.tetrahedra);
  return patches;
}

}  // namespace acus::mechanics
