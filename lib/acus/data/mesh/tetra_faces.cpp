#include "acus/data/mesh/tetra_faces.h"

#include <algorithm>
#include <tuple>

namespace acus::mesh {

std::vector<TetraFace> SortedFaces(const TetraMesh& mesh) {
  std::vector<TetraFace> faces;
  faces.reserve(4 * static_cast<std::size_t>(mesh.tetrahedra.cols()));
  for (int t = 0; t < mesh.tetrahedra.cols(); ++t) {
    for (int skip = 0; skip < 4; ++skip) {
      TetraFace face{{}, t};
      for (int c = 0, k = 0; c < 4; ++c) {
        if (c != skip) face.nodes[k++] = mesh.tetrahedra(c, t);
      }
      std::ranges::sort(face.nodes);
      faces.push_back(face);
    }
  }
  std::ranges::sort(faces, [](const TetraFace& a, const TetraFace& b) {
    return std::tie(a.nodes, a.tetrahedron) < std::tie(b.nodes, b.tetrahedron);
  });
  return faces;
}

std::vector<std::uint8_t> OuterNodes(const TetraMesh& mesh) {
  std::vector<std::uint8_t> is_outer(static_cast<std::size_t>(mesh.nodes_mm.cols()), 0);
  const std::vector<TetraFace> faces = SortedFaces(mesh);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const bool is_shared = (i > 0 && faces[i].IsSameFace(faces[i - 1])) ||
                           (i + 1 < faces.size() && faces[i].IsSameFace(faces[i + 1]));
    if (is_shared) continue;
    for (const int node : faces[i].nodes) is_outer[static_cast<std::size_t>(node)] = 1;
  }
  return is_outer;
}

}  // namespace acus::mesh
