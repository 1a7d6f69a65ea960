// A block of one tissue under air, its normal along +z, with an effect needle: in memory.
#pragma once

#include <cmath>

#include "acus/base/core/random.h"
#include "acus/data/volume/label_lookup.h"
#include "acus/scene/simulation/simulation.h"
#include "support/layered_scene.h"

namespace acus::testing_support {

inline scenario::NeedleEffect Bendable() {
  scenario::NeedleEffect effect;
  effect.model = scenario::NeedleModelKind::kBendable;
  return effect;
}

struct BendingScene {
  scenario::NeedleEffect effect = Bendable();
  scenario::NeedleForceModelKind force = scenario::NeedleForceModelKind::kLayered;
  const char* tissue = "muscle";  ///< Everything below z = 0; null: the layers of LayeredScene.
  const char* needle = "needles/spinal_22g.json";
  /// Without relaxation: the force on a needle at rest is constant.
  const char* table = "forces/bovine_2021.json";
  const char* elasticity = "elasticity/default.json";
  tissue::SpringSettings springs = {};  ///< With `force` kTissue.
  double bevel_curvature_per_mm = 0.0;
  double bevel_roll_rad = 0.0;
  Eigen::AlignedBox3d bone_mm;  ///< Empty: none.

  simulation::Scene Make() const {
    const std::filesystem::path configs = std::filesystem::path(ACUS_SOURCE_DIR) / "configs";
    scenario::Scenario s;
    s.file = "bending.json";
    s.patient.ct = "ct";
    s.patient.labels = "labels";
    s.needle_force.emplace().model = force;
    s.shape = effect;
    const bool has_springs = force == scenario::NeedleForceModelKind::kTissue;
    if (has_springs) s.tissue.emplace().model = scenario::TissueModelKind::kSprings;
    if (has_springs) s.tissue->image = false;
    volume::Geometry geometry = LayeredGeometry();
    geometry.size = {100, 100, 170};
    geometry.origin_mm = {-49.5, -49.5, -9.5};
    simulation::Scene scene = LayeredScene(
        simulation::PlanEffects(s, {.needle_poses = true, .probe_poses = true}), true, geometry);
    if (tissue != nullptr) {
      auto labels = std::make_shared<volume::LabelMap>(*scene.labels);
      for (auto& label : labels->voxels) label = label == 0 ? label : volume::LabelOf(tissue);
      scene.labels = labels;
    }
    if (!bone_mm.isEmpty()) {
      auto labels = std::make_shared<volume::LabelMap>(*scene.labels);
      for (int k = 0; k < geometry.size[2]; ++k) {
        for (int j = 0; j < geometry.size[1]; ++j) {
          for (int i = 0; i < geometry.size[0]; ++i) {
            const Eigen::Vector3d at_mm = geometry.ct_from_index() * Eigen::Vector3d(i, j, k);
            if (bone_mm.contains(at_mm)) {
              labels->voxels[geometry.Index(i, j, k)] = volume::LabelOf("bone");
            }
          }
        }
      }
      scene.labels = labels;
    }
    scene.needle = needle::ReadNeedle(configs / needle);
    scene.needle->bevel = {bevel_curvature_per_mm, bevel_roll_rad};
    const auto force_table = forces::ReadForceTable(configs / table);
    scene.forces.reset();
    scene.force_from_tissue = has_springs;
    const auto constants = mechanics::ReadElasticityTable(configs / elasticity);
    std::bitset<256> tissues;
    for (const auto label : scene.labels->voxels) tissues.set(label);
    if (has_springs) {
      scene.tissue.emplace(tissue::SpringModel(
          springs, force_table, *scene.needle, constants, tissues,
          [labels = scene.labels,
           index_from_ct = scene.labels->geometry.index_from_ct()](const Eigen::Vector3d& at_mm) {
            return volume::LabelAt(*labels, index_from_ct, at_mm);
          }));
    } else if (force == scenario::NeedleForceModelKind::kAlamilla) {
      scene.forces.emplace(forces::AlamillaModel(force_table, *scene.needle));
    } else {
      scene.forces.emplace(forces::NeedleForceModel(force_table, *scene.needle));
    }
    scene.shape.emplace(effect, *scene.needle,
                        force_table.ScaledTo(scene.needle->beam.outer_diameter_mm), &constants,
                        tissues, force == scenario::NeedleForceModelKind::kLayered);
    return scene;
  }
};

/// The needle's tip at a place, its axis turned from +z by a rotation vector.
inline simulation::Sample NeedleAt(double time_s, const Eigen::Vector3d& tip_mm,
                                   const Eigen::Vector3d& turn_rad = Eigen::Vector3d::Zero()) {
  simulation::Sample sample{.time_ns = std::llround(1e9 * time_s), .needle_valid = true};
  const double angle = turn_rad.norm();
  if (angle > 0.0) {
    sample.reference_from_needle.linear() =
        Eigen::AngleAxisd(angle, turn_rad / angle).toRotationMatrix();
  }
  sample.reference_from_needle.translation() = tip_mm;
  return sample;
}

}  // namespace acus::testing_support
