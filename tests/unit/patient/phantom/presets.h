// The patients that the tests share.
#pragma once

#include <filesystem>

#include "acus/data/volume/labels.h"
#include "acus/patient/phantom/anatomy/phantom_config.h"

namespace acus::phantom {

inline PhantomConfig Preset(const std::string& name) {
  return ReadPhantomConfig(std::filesystem::path(ACUS_SOURCE_DIR) / "configs" / "phantoms" /
                           (name + ".json"));
}

/// Exact anatomy, target and plan of a preset.
struct Case {
  Case(const std::string& preset, std::uint64_t seed)
      : config(Preset(preset)),
        anatomy(config.body, seed),
        field(anatomy, config.grid),
        target_ct_mm(anatomy.Landmark(config.insertion.target) + config.insertion.offset_mm),
        plan(PlanToTarget(field, target_ct_mm, config.insertion, {})) {}

  PhantomConfig config;
  Anatomy anatomy;
  AnatomyField field;
  Eigen::Vector3d target_ct_mm;
  InsertionPlan plan;
};

/// A body of soft tissue: an elliptic cylinder along z with 15 mm of fat under the skin, and a bar
/// of bone across its front. 0 = outside.
inline volume::LabelMap SyntheticBody(const Eigen::Array3i& size = {90, 70, 50},
                                      double spacing_mm = 4.0) {
  volume::Geometry g;
  g.size = size;
  g.spacing_mm = Eigen::Array3d::Constant(spacing_mm);
  g.origin_mm = -(0.5 * spacing_mm * (size - 1).cast<double>()).matrix();
  volume::LabelMap labels(g);
  for (const char* name : {"fat", "soft_tissue", "bone"}) {
    labels.names[volume::LabelOf(name)] = name;
  }
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const Eigen::Vector3d p = g.ct_from_index() * Eigen::Vector3d(i, j, k);
        const double r = std::hypot(p.x() / 140.0, p.y() / 105.0);
        if (r > 1.0) continue;
        const bool bar = p.y() < -60.0 && p.y() > -80.0;
        labels.At(i, j, k) = volume::LabelOf(bar ? "bone" : r > 0.87 ? "fat" : "soft_tissue");
      }
    }
  }
  return labels;
}

}  // namespace acus::phantom
