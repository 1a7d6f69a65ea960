// A needle, forces and a box of layered tissue, to test tissue::FemNeedleModel on.
#pragma once

#include <memory>
#include <vector>

#include "acus/physics/tissue/needle_contact.h"
#include "support/elastic_box.h"

namespace acus::testing_support {

/// Labels of the scene: 4 soft tissue with a skin of `skin_n`, 5 firmer inside, 6 bone.
/// @param time  of both soft tissues.  @param friction  of their friction.
inline forces::ForceTable SceneForces(const forces::TissueTime& time = {}, double friction = 1.0) {
  forces::ForceTable table;
  if (time != forces::TissueTime{}) {
    table.num_times = 2;
    table.times[1] = table.tissue[4].time = table.tissue[5].time = time;
    table.time_of[4] = table.time_of[5] = 1;
  }
  table.reference_diameter_mm = 1.2;
  table.settings.cutting_stiffness_n_per_mm = 2.0;
  table.settings.friction_buildup_mm = 0.5;
  table.settings.interface_hysteresis_mm = 0.3;
  table.settings.lateral_limit_n = 3.0;
  table.settings.bone = {10.0, 0.01, 20.0};
  table.settings.invalid_hold_s = 0.1;
  table.settings.invalid_ramp_s = 0.2;
  table.settings.largest_force_n = 30.0;
  table.tissue[4].membrane = {0.1, 0.01, 1.5};
  table.tissue[4].no_membrane_from.set(5);
  table.tissue[4].cutting_n = 0.5;
  table.tissue[4].friction_n_per_mm = 0.02 * friction;
  table.tissue[5].membrane = {0.1, 0.01, 1.2};
  table.tissue[5].cutting_n = 0.8;
  table.tissue[5].friction_n_per_mm = 0.03 * friction;
  table.tissue[6].impenetrable = true;
  return table;
}

inline forces::NeedleProperties SceneNeedle() {
  forces::NeedleProperties needle;
  needle.name = "test";
  needle.length_mm = 100.0;
  needle.beam.outer_diameter_mm = 1.2;
  needle.beam.youngs_modulus_mpa = 2e5;
  return needle;
}

struct SceneOptions {
  Eigen::Vector3i cells{6, 6, 6};
  double edge_mm = 60.0;  ///< From -edge/2 to edge/2, and 0 to edge along z.
  double jitter = 0.1;
  double inner_below_mm = -1.0;  ///< Tetrahedra below this height are of label 5.
  double bone_below_mm = -1.0;   ///< Those below this of label 6, their nodes fixed.
  double soft_mpa = 0.02;
  double inner_mpa = 0.05;
  mechanics::HyperelasticLaw law{};  ///< Of both; read where contact.strain is set.
  mechanics::Storage storage = mechanics::Storage::kDouble;
  double reach_mm = 1e9;  ///< Nodes within this of the z axis are in the compliance.
  tissue::FemContactSettings contact{};
  mechanics::Relaxation relaxation{};
  forces::TissueTime time{};
  double friction = 1.0;  ///< Of that of the tissues.
  std::vector<mechanics::Membrane> membranes{};
};

inline double HeightOf(const mesh::TetraMesh& mesh, Eigen::Index t) {
  double z = 0.0;
  for (int c = 0; c < 4; ++c) z += 0.25 * mesh.nodes_mm(2, mesh.tetrahedra(c, t));
  return z;
}

/// A box whose top at z = edge is the skin; the bottom and the sides are held.
inline mesh::TetraMesh SceneMesh(const SceneOptions& options) {
  const double half_mm = 0.5 * options.edge_mm;
  mesh::TetraMesh box = BoxMesh(options.cells, {-half_mm, -half_mm, 0.0},
                                {half_mm, half_mm, options.edge_mm}, options.jitter);
  Fix(box, [&](const Eigen::Vector3d& x) {
    return x.z() < 1e-6 || x.head<2>().cwiseAbs().maxCoeff() > half_mm - 1e-6;
  });
  for (Eigen::Index t = 0; t < box.tetrahedra.cols(); ++t) {
    if (HeightOf(box, t) < options.inner_below_mm) box.tissue[static_cast<std::size_t>(t)] = 5;
    if (HeightOf(box, t) >= options.bone_below_mm) continue;
    box.tissue[static_cast<std::size_t>(t)] = 6;
    for (int c = 0; c < 4; ++c) {
      box.fixed_nodes[static_cast<std::size_t>(box.tetrahedra(c, t))] = 1;
    }
  }
  return box;
}

inline mechanics::ElasticityTable SceneElasticity(const SceneOptions& options) {
  mechanics::ElasticityTable table =
      ElasticLabels({{4, {options.soft_mpa, 0.45}}, {5, {options.inner_mpa, 0.45}}});
  table.law[4] = table.law[5] = options.law;
  table.relaxation = options.relaxation;
  table.membranes = options.membranes;
  return table;
}

struct FemScene {
  explicit FemScene(const SceneOptions& options = {})
      : mesh(SceneMesh(options)),
        compliance(ComplianceOf(
            mesh, SceneElasticity(options), options.storage,
            [&](const Eigen::Vector3d& x) { return x.head<2>().norm() <= options.reach_mm; })),
        model(mesh, compliance, SceneElasticity(options),
              SceneForces(options.time, options.friction), SceneNeedle(), options.contact),
        state(model.NewState()) {}

  /// The tip at this depth below the top of a box of 60 mm, 1 ms after the last.
  forces::NeedleForce StepAt(double depth_mm, double x_mm = 0.3, double y_mm = -0.7,
                             double tilt_x = 0.0) {
    tissue::ToolSample sample;
    sample.time_s = time_s += step_s;
    sample.tip_in_ct_mm = {x_mm, y_mm, 60.0 - depth_mm};
    sample.axis_in_ct = Eigen::Vector3d(tilt_x, 0.0, -1.0).normalized();
    return model.Step(state, sample);
  }

  /// From one depth to another at this speed.
  forces::NeedleForce Move(double from_mm, double to_mm, double mm_per_step = 0.1) {
    const int steps = std::max(1, static_cast<int>(std::abs(to_mm - from_mm) / mm_per_step));
    forces::NeedleForce force;
    for (int s = 1; s <= steps; ++s) force = StepAt(from_mm + (to_mm - from_mm) * s / steps);
    return force;
  }

  mesh::TetraMesh mesh;
  mechanics::Compliance compliance;
  tissue::FemNeedleModel model;
  tissue::FemNeedleState state;
  double time_s = 0.0;
  double step_s = 1e-3;
};

}  // namespace acus::testing_support
