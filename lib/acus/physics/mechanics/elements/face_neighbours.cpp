#include "acus/physics/mechanics/elements/face_neighbours.h"

#include <algorithm>
#include <vector>

#include "acus/data/mesh/tetra_faces.h"

namespace acus::mechanics {
namespace {

/// The corner of its tetrahedron that is not on the face.
int OppositeCorner(const mesh::TetraMesh& mesh, const mesh::TetraFace& face) {
  int corner = 0;
  while (std::ranges::count(face.nodes, mesh.tetrahedra(corner, face.tetrahedron)) > 0) ++corner;
  return corner;
}

}  // namespace

Eigen::Matrix4Xi FaceNeighbours(const mesh::TetraMesh& mesh) {
  const std::vector<mesh::TetraFace> faces = mesh::SortedFaces(mesh);
  Eigen::Matrix4Xi neighbours = Eigen::Matrix4Xi::Constant(4, mesh.tetrahedra.cols(), -1);
  for (std::size_t i = 1; i < faces.size(); ++i) {
    if (!faces[i].IsSameFace(faces[i - 1])) continue;
    int& behind = neighbours(OppositeCorner(mesh, faces[i - 1]), faces[i - 1].tetrahedron);
    if (behind >= 0) continue;
    behind = faces[i].tetrahedron;
    neighbours(OppositeCorner(mesh, faces[i]), faces[i].tetrahedron) = faces[i - 1].tetrahedron;
  }
  return neighbours;
}

}  // namespace acus::mechanics
