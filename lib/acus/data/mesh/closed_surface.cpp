#include "acus/data/mesh/closed_surface.h"

#include "acus/base/core/error.h"
#include "acus/data/mesh/surface_edges.h"

namespace acus::mesh {

Winding CheckClosed(const Surface& surface, const std::string& label) {
  ACUS_REQUIRE(surface.triangles.cols() > 0, label, ": has no triangle");
  ACUS_REQUIRE(surface.nodes_mm.allFinite(), label, ": a coordinate is not finite");
  std::size_t open = 0;
  bool oriented = true;
  Eigen::Vector3d first_mm = Eigen::Vector3d::Zero();
  const auto edges = SortedHalfEdges(surface.triangles);
  ForEachEdge(edges, [&](const HalfEdge* edge, std::size_t count) {
    if (edge->low == edge->high) return;  // A triangle without area.
    int forward = 0;
    for (std::size_t n = 0; n < count; ++n) forward += edge[n].is_forward ? 1 : -1;
    if (forward != 0) oriented = false;
    if (count % 2 == 0) return;
    if (open++ == 0) first_mm = surface.nodes_mm.col(edge->low);
  });
  ACUS_REQUIRE(
      open == 0, label, ": is not closed: ", open,
      " edges have a triangle on one side "
      "only, the first near (",
      first_mm[0], ", ", first_mm[1], ", ", first_mm[2],
      ") mm; what is inside of it cannot be determined. Close its holes (acus-mesh closes small "
      "ones) or leave it out of the list");
  return oriented ? Winding::kOriented : Winding::kUnoriented;
}

}  // namespace acus::mesh
