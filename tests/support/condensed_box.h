// A small box of tissue, condensed.
#pragma once

#include "acus/physics/mechanics/condensation/condensation.h"
#include "acus/physics/mechanics/condensation/reachable.h"
#include "support/box_mesh.h"

namespace acus::testing_support {

/// 32 x 32 x 32 mm in cells of 4 mm, of soft tissue (E 5 kPa, nu 0.45), held at z = 0; a corridor
/// of 3 mm about the line x = y = 16 mm from the top to the middle.
struct CondensedBox {
  mesh::TetraMesh mesh = BoxMesh({8, 8, 8}, {0, 0, 0}, {32, 32, 32}, 0.15);
  mechanics::ElasticityTable elasticity;
  mechanics::FreeNodes free;
  mechanics::Capsule corridor{{16, 16, 33}, {16, 16, 16}, 3.0};
  std::vector<int> reachable;
  std::vector<int> visible;  ///< Within 9 mm of the corridor's axis.

  CondensedBox() {
    Fix(mesh, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
    elasticity.file = "box.json";
    elasticity.tissue[4] = {0.005, 0.45};
    elasticity.named.set(4);
    free = mechanics::FindFreeNodes(mesh);
    reachable = mechanics::CorridorNodes(mesh, free, corridor);
    visible = mechanics::Joined(
        reachable, mechanics::NodesInside(mesh, free, {corridor.from_mm, corridor.to_mm, 9.0}));
  }

  mechanics::Condensation Condense() const {
    return {mesh,        free,
            elasticity,  mechanics::ElementKind::kLinear,
            reachable,   mechanics::kDefaultMemoryMib,
            RunContext{}};
  }
};

}  // namespace acus::testing_support
