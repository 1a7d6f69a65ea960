// A small trunk of which every voxel's tissue is known.
#pragma once

#include <cmath>

#include "acus/base/core/random.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume.h"

namespace acus::segmentation {

struct SyntheticBody {
  volume::CtVolume ct;
  volume::LabelMap truth;  ///< Without skin.
};

struct SyntheticOptions {
  double spacing_mm = 1.5;
  double noise_hu = 12.0;
  double blood_hu = 45.0;  ///< A vessel of 22 mm beside the spine; 300 with contrast agent.
  bool has_table = true;
  double depth_mm = 170.0;  ///< Of the volume, from y = -80.
};

/// An elliptic trunk with a fat layer, one lung, bowel gas, a vertebra (cortex 700, marrow 150 HU,
/// with a canal), a rib (cortex around fatty marrow), a vessel, on a table of 3 mm carbon fibre.
inline SyntheticBody MakeSyntheticBody(const SyntheticOptions& options) {
  volume::Geometry g;
  g.spacing_mm = Eigen::Array3d(options.spacing_mm, options.spacing_mm, 2.0);
  g.size = {static_cast<int>(200 / options.spacing_mm),
            static_cast<int>(options.depth_mm / options.spacing_mm), 30};
  g.origin_mm = {-100.0, -80.0, 0.0};
  SyntheticBody body{volume::CtVolume(g, -1000), volume::LabelMap(g)};
  RandomStream random(9, "noise", 0);
  const auto within = [](double x, double y, double cx, double cy, double rx, double ry) {
    return std::pow((x - cx) / rx, 2) + std::pow((y - cy) / ry, 2) <= 1.0;
  };
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Eigen::Vector3d p = g.ct_from_index() * Eigen::Vector3d(i, j, k);
        const double x = p[0], y = p[1];
        const char* tissue = "outside";
        double hu = -1000.0;
        const auto set = [&](const char* name, double value) {
          tissue = name;
          hu = value;
        };
        if (options.has_table && y > 66.0 && y < 69.0) hu = 150.0;
        if (within(x, y, 0, 0, 90, 64)) set("fat", -100);
        if (within(x, y, 0, 0, 80, 54)) set("soft_tissue", 50);
        if (within(x, y, -45, -15, 22, 28)) set("lung", -850);
        if (within(x, y, 35, -25, 14, 10)) set("gas", -1000);
        if (within(x, y, 28, 12, 11, 11)) set("soft_tissue", options.blood_hu);
        if (within(x, y, 0, 20, 17, 14)) set("bone", within(x, y, 0, 20, 14, 11) ? 150 : 700);
        if (within(x, y, 0, 42, 13, 11)) set("bone", 700);
        if (within(x, y, 0, 42, 9, 7)) set("soft_tissue", 20);
        if (within(x, y, 68, -15, 5, 9)) set("bone", within(x, y, 68, -15, 3, 6) ? -40 : 600);
        const double noise = options.noise_hu * random.Normal();
        body.ct.At(i, j, k) = static_cast<std::int16_t>(std::lround(std::max(-1024.0, hu + noise)));
        body.truth.At(i, j, k) = volume::LabelOf(tissue);
      }
    }
  }
  return body;
}

}  // namespace acus::segmentation
