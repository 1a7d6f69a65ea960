// A small trunk as labels: lungs over a liver within a barrel of ribs, spine behind, fat around.
#pragma once

#include <algorithm>
#include <cmath>

#include "acus/data/volume/labels.h"

namespace acus::testing_support {

/// Axis-aligned, 4 mm, centre of the volume at the origin; the inner face of the barrel is the
/// ellipse x/120, y/85, from bottom to top; the dome of the diaphragm is at z = 0, the lungs end at
/// z = 120.
inline volume::LabelMap SyntheticTrunk() {
  volume::Geometry g;
  g.size = {76, 58, 72};
  g.spacing_mm = Eigen::Array3d::Constant(4.0);
  g.origin_mm = -(2.0 * (g.size - 1).cast<double>()).matrix();
  volume::LabelMap labels(g);
  for (const char* name : {"skin", "fat", "soft_tissue", "bone", "lung"}) {
    labels.names[volume::LabelOf(name)] = name;
  }
  const auto put = [&](int i, int j, int k, const char* name) {
    labels.At(i, j, k) = volume::LabelOf(name);
  };
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Eigen::Vector3d p = g.origin_mm + 4.0 * Eigen::Vector3d(i, j, k);
        const double inner = std::hypot(p.x() / 120.0, p.y() / 85.0);
        const double wall_mm = (inner - 1.0) * 100.0;
        if (wall_mm > 25.0) continue;
        put(i, j, k, wall_mm > 21.0 ? "skin" : wall_mm > 12.0 ? "fat" : "soft_tissue");
        const bool rib = std::fmod(p.z() + 200.0, 24.0) < 12.0;
        if (wall_mm > 0.0 && wall_mm < 8.0 && rib) put(i, j, k, "bone");
        const double dome = -40.0 * std::pow((std::abs(p.x()) - 60.0) / 60.0, 2.0);
        if (wall_mm < 0.0 && std::abs(p.x()) > 16.0 && p.z() > dome && p.z() < 120.0) {
          put(i, j, k, "lung");
        }
        if (std::hypot(p.x(), p.y() - 80.0) < 22.0) put(i, j, k, "bone");
      }
    }
  }
  return labels;
}

}  // namespace acus::testing_support
