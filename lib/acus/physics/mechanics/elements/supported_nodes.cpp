#include "acus/physics/mechanics/elements/supported_nodes.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/data/mesh/quality.h"
#include "acus/physics/mechanics/elements/face_neighbours.h"

namespace acus::mechanics {
namespace {

void CheckSizes(const mesh::TetraMesh& mesh) {
  const auto num_nodes = static_cast<std::size_t>(mesh.nodes_mm.cols());
  const auto num_tetrahedra = static_cast<std::size_t>(mesh.tetrahedra.cols());
  ACUS_REQUIRE(num_tetrahedra > 0, "the mesh has no tetrahedra");
  ACUS_REQUIRE(mesh.tissue.size() == num_tetrahedra, "the mesh has ", num_tetrahedra,
               " tetrahedra but ", mesh.tissue.size(), " tissue ids; mesh it with acus-mesh");
  ACUS_REQUIRE(mesh.fixed_nodes.size() == num_nodes, "the mesh has ", num_nodes, " nodes but ",
               mesh.fixed_nodes.size(), " fixed flags; mesh it with acus-mesh");
  ACUS_REQUIRE(mesh.tetrahedra.minCoeff() >= 0 && mesh.tetrahedra.maxCoeff() < mesh.nodes_mm.cols(),
               "a tetrahedron of the mesh names a node that is not there");
}

/// Piece of each tetrahedron: those joined by faces have the same, numbered from 0.
std::vector<int> FaceConnectedPieces(const mesh::TetraMesh& mesh) {
  const Eigen::Matrix4Xi neighbours = FaceNeighbours(mesh);
  std::vector<int> piece(static_cast<std::size_t>(mesh.tetrahedra.cols()), -1);
  std::vector<int> reached;
  int count = 0;
  for (int seed = 0; seed < mesh.tetrahedra.cols(); ++seed) {
    if (piece[seed] >= 0) continue;
    piece[seed] = count;
    reached.assign(1, seed);
    while (!reached.empty()) {
      const int t = reached.back();
      reached.pop_back();
      for (const int next : neighbours.col(t)) {
        if (next < 0 || piece[next] >= 0) continue;
        piece[next] = count;
        reached.push_back(next);
      }
    }
    ++count;
  }
  return piece;
}

/// Whether what is held at these places cannot turn: three of them are not on one line.
bool HoldsFirmly(const Eigen::Matrix3Xd& nodes_mm, const std::vector<int>& held) {
  if (held.size() < 3) return false;
  const Eigen::Vector3d first = nodes_mm.col(held[0]);
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();
  for (const int node : held) {
    if ((nodes_mm.col(node) - first).norm() > arm.norm()) arm = nodes_mm.col(node) - first;
  }
  return std::ranges::any_of(held, [&](int node) {
    return arm.cross(nodes_mm.col(node) - first).norm() > 1e-6 * arm.squaredNorm();
  });
}

/// Nodes of each piece, ascending, each once.
std::vector<std::vector<int>> NodesOfPieces(const mesh::TetraMesh& mesh,
                                            const std::vector<int>& piece) {
  std::vector<std::vector<int>> nodes(1 + *std::ranges::max_element(piece));
  for (std::size_t t = 0; t < piece.size(); ++t) {
    for (int c = 0; c < 4; ++c) nodes[piece[t]].push_back(mesh.tetrahedra(c, t));
  }
  for (std::vector<int>& of_one : nodes) {
    std::ranges::sort(of_one);
    of_one.erase(std::unique(of_one.begin(), of_one.end()), of_one.end());
  }
  return nodes;
}

/// Flags of the pieces that are held by fixed nodes or by pieces that are.
std::vector<std::uint8_t> SupportedPieces(const mesh::TetraMesh& mesh,
                                          const std::vector<std::vector<int>>& nodes_of_piece) {
  std::vector<std::uint8_t> is_held = mesh.fixed_nodes;
  std::vector<std::uint8_t> is_supported(nodes_of_piece.size(), 0);
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t p = 0; p < nodes_of_piece.size(); ++p) {
      if (is_supported[p]) continue;
      std::vector<int> held;
      std::ranges::copy_if(nodes_of_piece[p], std::back_inserter(held),
                           [&](int node) { return is_held[node] != 0; });
      if (!HoldsFirmly(mesh.nodes_mm, held)) continue;
      is_supported[p] = 1;
      for (const int node : nodes_of_piece[p]) is_held[node] = 1;
      changed = true;
    }
  }
  return is_supported;
}

std::vector<LoosePiece> LoosePieces(const mesh::TetraMesh& mesh, const std::vector<int>& piece,
                                    const std::vector<std::uint8_t>& is_supported) {
  std::vector<LoosePiece> all(is_supported.size());
  double total_mm3 = 0.0;
  double loose_mm3 = 0.0;
  for (std::size_t t = 0; t < piece.size(); ++t) {
    const double volume_mm3 = mesh::VolumeMm3(mesh::CornersOf(mesh, static_cast<int>(t)));
    total_mm3 += volume_mm3;
    if (is_supported[piece[t]]) continue;
    LoosePiece& loose = all[piece[t]];
    ++loose.num_tetrahedra;
    loose.volume_mm3 += volume_mm3;
    loose_mm3 += volume_mm3;
    for (int c = 0; c < 4; ++c) {
      loose.centre_mm += 0.25 * volume_mm3 * mesh.nodes_mm.col(mesh.tetrahedra(c, t));
    }
  }
  std::erase_if(all, [](const LoosePiece& p) { return p.num_tetrahedra == 0; });
  for (LoosePiece& loose : all) loose.centre_mm /= loose.volume_mm3;
  std::ranges::stable_sort(all, std::greater<>{}, &LoosePiece::volume_mm3);
  if (!all.empty()) {
    const Eigen::Vector3d at = all[0].centre_mm;
    ACUS_REQUIRE(
        loose_mm3 <= kLargestLooseShare * total_mm3, all.size(),
        all.size() == 1 ? " piece" : " pieces", " of the mesh, ", 100.0 * loose_mm3 / total_mm3,
        " % of its volume, are held by nothing; the largest is of ", all[0].num_tetrahedra,
        " tetrahedra, ", all[0].volume_mm3, " mm^3, about (", at.x(), ", ", at.y(), ", ", at.z(),
        ") mm. Hold a tissue in it (fixed_tissues of the mesh configuration) or leave it out of ",
        "the label map");
  }
  return all;
}

}  // namespace

FreeNodes FindFreeNodes(const mesh::TetraMesh& mesh) {
  CheckSizes(mesh);
  ACUS_REQUIRE(
      std::ranges::any_of(mesh.fixed_nodes, [](auto flag) { return flag != 0; }),
      "no node of the mesh is fixed, so that any force would carry it away; mesh it with a "
      "tissue that stays in place, such as \"fixed_tissues\": [\"bone\"]");
  const std::vector<int> piece = FaceConnectedPieces(mesh);
  const auto nodes_of_piece = NodesOfPieces(mesh, piece);
  const std::vector<std::uint8_t> is_supported = SupportedPieces(mesh, nodes_of_piece);

  FreeNodes free;
  free.loose = LoosePieces(mesh, piece, is_supported);
  free.is_left_out.resize(piece.size());
  for (std::size_t t = 0; t < piece.size(); ++t) free.is_left_out[t] = !is_supported[piece[t]];
  std::vector<std::uint8_t> moves(mesh.fixed_nodes.size(), 0);
  for (std::size_t p = 0; p < nodes_of_piece.size(); ++p) {
    if (!is_supported[p]) continue;
    for (const int node : nodes_of_piece[p]) moves[node] = mesh.fixed_nodes[node] == 0;
  }
  free.row_of_node.assign(moves.size(), -1);
  for (std::size_t node = 0; node < moves.size(); ++node) {
    if (!moves[node]) continue;
    free.row_of_node[node] = static_cast<int>(free.mesh_node.size());
    free.mesh_node.push_back(static_cast<int>(node));
  }
  ACUS_REQUIRE(!free.mesh_node.empty(), "every node of the mesh is held; nothing can be deformed");
  return free;
}

}  // namespace acus::mechanics
