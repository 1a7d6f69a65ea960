// A surface with as many nodes as one likes.
#pragma once

#include <cmath>

#include "acus/data/mesh/surface.h"

namespace acus::testing_support {

/// A sheet wound around the body's axis, of so many nodes.
inline mesh::Surface WoundSheet(Eigen::Index nodes) {
  mesh::Surface surface;
  surface.nodes_mm.resize(3, nodes);
  surface.triangles.resize(3, nodes - 2);
  for (Eigen::Index n = 0; n < nodes; ++n) {
    const double turn = 8e-3 * static_cast<double>(n);
    surface.nodes_mm.col(n) << 160.0 * std::cos(turn), 110.0 * std::sin(turn),
        -140.0 + 280.0 * static_cast<double>(n) / static_cast<double>(nodes);
    if (n < 2) continue;
    const auto last = static_cast<int>(n);
    surface.triangles.col(n - 2) << last - 2, last - 1, last;
  }
  return surface;
}

}  // namespace acus::testing_support
