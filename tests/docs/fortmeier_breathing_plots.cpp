// Repeats the lower half of figure 5, and figure 8, of Fortmeier-2016:
// fortmeier_breathing_plots PATIENT_FOLDER OUT_FOLDER
#include <cmath>
#include <iostream>

#include "acus/base/report/svg_plot.h"
#include "acus/data/volume/label_lookup.h"
#include "acus/physics/breathing/tool_at_rest.h"
#include "acus/scene/simulation/simulation.h"
#include "support/bending_scene.h"
#include "support/breathing_liver.h"
#include "support/fortmeier_liver.h"

namespace {

using namespace acus;  // NOLINT: a program of one file.
using breathing::MotionMap;
using Eigen::Vector3d;

/// The paper's parameters for punctures of the liver, section 4.1, in all tissue of the patient.
tissue::SpringModel PunctureSprings(const testing_support::BreathingLiver& patient) {
  using L = testing_support::FortmeierLiver;
  constexpr double kDiameterMm = 1.27;
  tissue::SpringSettings settings;
  settings.node_spacing_mm = L::kSpacingMm;
  const double per_modulus = 2.0 * std::numbers::pi * L::kSpacingMm /
                             std::log(settings.influence_radius_mm / (0.5 * kDiameterMm));
  const double shear_mpa = L::kNodeNPerMm / per_modulus;
  nlohmann::json forces = {{"format", "acus-forces/1"},
                           {"reference_diameter_mm", kDiameterMm},
                           {"tissues", nlohmann::json::array()}};
  nlohmann::json elasticity = {{"format", "acus-elasticity/1"},
                               {"tissues", nlohmann::json::array()}};
  for (const char* tissue : {"soft_tissue", "liver"}) {
    forces["tissues"].push_back({{"tissue", tissue},
                                 {"source", "paper"},
                                 {"a1_n_per_mm", 1.2},
                                 {"a2_n_per_mm2", 0.0},
                                 {"puncture_n", 0.3},
                                 {"cutting_n", 0.3},
                                 {"friction_n_per_mm", L::kFrictionN / L::kSpacingMm}});
    elasticity["tissues"].push_back({{"tissue", tissue},
                                     {"source", "paper"},
                                     {"youngs_modulus_kpa", 2e3 * shear_mpa * 1.45},
                                     {"poissons_ratio", 0.45}});
  }
  forces::NeedleProperties needle;
  needle.length_mm = 200.0;
  needle.beam.outer_diameter_mm = kDiameterMm;
  needle.beam.youngs_modulus_mpa = 193e3;
  std::bitset<256> labels;
  labels.set(volume::LabelOf("soft_tissue"));
  labels.set(volume::LabelOf("liver"));
  const Eigen::Affine3d index_from_ct = patient.labels.geometry.index_from_ct();
  return {settings,
          forces::ForceTableFromJson(forces, "figure 5"),
          needle,
          mechanics::ElasticityTableFromJson(elasticity, "figure 5"),
          labels,
          [&patient, index_from_ct](const Vector3d& at_mm) -> volume::Label {
            const volume::Label label = volume::LabelAt(patient.labels, index_from_ct, at_mm);
            if (label == 0) return 0;
            return volume::LabelOf(label == volume::LabelOf("liver") ? "liver" : "soft_tissue");
          }};
}

/// Depth of the tip along its line: to 60 mm in 10 s, a pause of 6 s, 25 mm more in 4 s, a pause of
/// 6 s, and out in 6 s. The paper tells the order, but the 10 s only.
double DepthMm(double t) {
  const double in = 60.0 * std::clamp(t / 10.0, 0.0, 1.0);
  const double further = 25.0 * std::clamp((t - 16.0) / 4.0, 0.0, 1.0);
  const double out = 95.0 * std::clamp((t - 26.0) / 6.0, 0.0, 1.0);
  return -5.0 + in + further - out;
}

struct Line {
  Vector3d skin_mm;
  Vector3d direction;
};

/// From the skin of the belly upwards and backwards to the middle of the liver.
Line TowardsLiver(const testing_support::BreathingLiver& patient) {
  const Eigen::Affine3d ct_from_index = patient.labels.geometry.ct_from_index();
  const Eigen::Affine3d index_from_ct = ct_from_index.inverse();
  Vector3d middle = Vector3d::Zero();
  double count = 0.0;
  const volume::Geometry& g = patient.labels.geometry;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        if (patient.labels.At(i, j, k) != volume::LabelOf("liver")) continue;
        middle += ct_from_index * Vector3d(i, j, k);
        ++count;
      }
    }
  }
  middle /= count;
  const Vector3d direction = Vector3d(0.0, 0.6, 0.8);
  Vector3d at = middle;
  while (volume::LabelAt(patient.labels, index_from_ct, at) != 0) at -= 0.5 * direction;
  return {at, direction};
}

void DrawFigure5(const testing_support::BreathingLiver& patient,
                 const std::filesystem::path& file) {
  const tissue::SpringModel springs = PunctureSprings(patient);
  const breathing::MotionModel model = patient.Model(breathing::MotionKind::kSurrogate);
  const Line line = TowardsLiver(patient);
  report::Plot plot;
  plot.title = "Towards the head into the liver: in 10 s, a pause, further, a pause, and out";
  plot.x_label = "time [s]";
  plot.y_label = "force against insertion [N]";
  for (const bool breathes : {true, false}) {
    report::Series series{.name = breathes ? "with respiratory motion" : "without"};
    tissue::SpringState state = springs.NewState();
    breathing::ToolTrack track;
    for (int n = 0; n < 33000; ++n) {
      const double t = 1e-3 * n;
      Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
      pose.linear() =
          Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), line.direction).toRotationMatrix();
      pose.translation() = line.skin_mm + DepthMm(t) * line.direction;
      // Breath begins at end expiration, as the CT was taken.
      const MotionMap map(model.field(),
                          model.WeightsAt(patient.BreathAt(0.5 + t / 4.0), breathes ? 1.0 : 0.0));
      const breathing::ToolAtRest at_rest = AtRest(map, pose, Vector3d::UnitZ(), track);
      tissue::ToolSample sample;
      sample.time_s = t + 1e-3;
      sample.tip_in_ct_mm = at_rest.ct_from_tool.translation();
      sample.axis_in_ct = at_rest.ct_from_tool.linear().col(2);
      Vector3d force_n = springs.Step(state, sample).force_in_ct_n;
      Vector3d torque_n_mm = Vector3d::Zero();
      CarryToWorld(map, at_rest, force_n, torque_n_mm);
      series.x.push_back(t);
      series.y.push_back(-force_n.dot(line.direction));
    }
    plot.series.push_back(std::move(series));
  }
  for (const auto& [from_s, to_s, text] : {std::tuple{0.0, 10.0, "in"},
                                           {10.0, 16.0, "pause"},
                                           {16.0, 20.0, "in"},
                                           {20.0, 26.0, "pause"},
                                           {26.0, 32.0, "out"}}) {
    plot.spans.push_back({from_s, to_s, text});
  }
  WriteSvg(file, plot);
}

/// A block that moves sideways with breath in its deeper part only.
simulation::Breathing DeepPartMoves() {
  volume::Geometry nodes;
  nodes.size = {9, 9, 65};
  nodes.spacing_mm = {40.0, 40.0, 4.0};
  nodes.origin_mm = {-160.0, -160.0, -60.0};
  breathing::MotionField field(nodes, 1);
  std::vector<float> values;
  for (int k = 0; k < nodes.size[2]; ++k) {
    const double z_mm = nodes.origin_mm[2] + nodes.spacing_mm[2] * k;
    const double s = std::clamp(z_mm / 40.0, 0.0, 1.0);
    for (int n = 0; n < 81; ++n) {
      values.insert(values.end(), {static_cast<float>(10.0 * s * s * (3.0 - 2.0 * s)), 0.0F, 0.0F});
    }
  }
  field.SetComponent(0, values);
  return {.motion = {.name = "deep part",
                     .model = breathing::MotionModel::Sinusoid(std::move(field), 1.0)},
          .source = {breathing::BreathingPattern({.period_s = 4.0, .exponent = 1}), {}}};
}

/// Lines of the tissue, moved by the map, as one line to and fro.
report::Series Grid(const MotionMap* map, double to_mm) {
  report::Series grid{.name = "tissue"};
  const auto add = [&](double x, double z) {
    const Vector3d rest(x, 0.0, z);
    const Vector3d at = map == nullptr ? rest : map->WorldMm(rest);
    grid.x.push_back(at.z());
    grid.y.push_back(at.x());
  };
  constexpr double kStepMm = 5.0;
  bool back = false;
  for (double x = -15.0; x <= 25.0; x += kStepMm, back = !back) {
    for (double s = 0.0; s <= to_mm; s += 1.0) add(x, back ? to_mm - s : s);
  }
  for (double z = back ? to_mm : 0.0; z >= 0.0 && z <= to_mm; z += back ? -kStepMm : kStepMm) {
    const bool down = std::lround(z / kStepMm) % 2 == 0;
    for (double s = 0.0; s <= 40.0; s += 1.0) add(down ? 25.0 - s : -15.0 + s, z);
  }
  return grid;
}

struct Shapes {
  std::vector<Vector3d> path_mm;  ///< At rest.
  math::Polyline needle_mm;       ///< In the world.
};

void DrawFigure8(const Shapes& shapes, const MotionMap* map, const std::string& title,
                 const std::filesystem::path& file) {
  std::vector<report::Plot> plots;
  for (const bool world : {true, false}) {
    report::Plot plot;
    plot.title = title + (world ? ", world space" : ", reference space");
    plot.y_label = "across [mm]";
    plot.x_label = "depth [mm]";
    plot.height_px = 400;
    report::Series needle{.name = "needle"};
    for (int n = 0; n < shapes.needle_mm.num_points; ++n) {
      const Vector3d at = shapes.needle_mm.At(n);
      const Vector3d shown = world || map == nullptr ? at : map->RestOf(at, at, {}).rest_mm;
      if (shown.z() < -15.0) continue;
      needle.x.push_back(shown.z());
      needle.y.push_back(shown.x());
    }
    report::Series path{.name = "path", .style = report::Style::kPoints};
    for (const Vector3d& rest : shapes.path_mm) {
      const Vector3d at = world && map != nullptr ? map->WorldMm(rest) : rest;
      path.x.push_back(at.z());
      path.y.push_back(at.x());
    }
    plot.series = {Grid(world ? map : nullptr, 60.0), std::move(needle), std::move(path)};
    plots.push_back(std::move(plot));
  }
  WriteSvg(file, plots);
}

/// Steps a needle through `pose_at` and keeps what is drawn at the end.
template <typename PoseAt>
Shapes Insert(const simulation::Scene& scene, double duration_s, const PoseAt& pose_at) {
  const simulation::Simulation simulation(scene);
  simulation::State state = simulation.NewState();
  for (int n = 0; n <= static_cast<int>(1e3 * duration_s); ++n) {
    simulation.Step(state, pose_at(1e-3 * n));
  }
  Shapes shapes;
  simulation.ShapeOf(state, shapes.needle_mm);
  const needle::CurvedPath& path = state.shape.needle.path;
  for (int n = 0; n < path.num_nodes; n += 2) {
    shapes.path_mm.push_back(path.node[static_cast<std::size_t>(n)].position_mm);
  }
  return shapes;
}

void DrawFigure8s(const std::filesystem::path& out) {
  testing_support::BendingScene bending;
  {
    // In to 10 mm, held and angulated by 15 degrees about the skin, in further.
    const simulation::Scene scene = bending.Make();
    const Shapes shapes = Insert(scene, 6.0, [](double t) {
      const double lean = 0.26 * std::clamp((t - 1.5) / 1.5, 0.0, 1.0);
      const double depth_mm =
          10.0 * std::min(t, 1.0) + 45.0 * std::clamp((t - 3.0) / 3.0, 0.0, 1.0);
      return testing_support::NeedleAt(
          t, {depth_mm * std::sin(lean), 0.0, depth_mm * std::cos(lean)}, {0.0, lean, 0.0});
    });
    DrawFigure8(shapes, nullptr, "The hand leans after 10 mm", out / "fortmeier_8_angulation.svg");
  }
  // In straight within a second around mid expiration: the deep part moves meanwhile.
  simulation::Scene scene = bending.Make();
  scene.breathing.emplace(DeepPartMoves());
  constexpr double kEndS = 2.0;
  const Shapes shapes = Insert(scene, kEndS, [](double t) {
    return testing_support::NeedleAt(t, {0.0, 0.0, -2.0 + 57.0 * std::clamp(t / kEndS, 0.0, 1.0)});
  });
  const MotionMap map = scene.breathing->At(kEndS, {});
  DrawFigure8(shapes, &map, "The deep part of the tissue moves during insertion",
              out / "fortmeier_8_breathing.svg");
}

void Draw(const std::filesystem::path& folder, const std::filesystem::path& out) {
  DrawFigure8s(out);
  const testing_support::BreathingLiver patient(folder, {});
  DrawFigure5(patient, out / "fortmeier_5_lower.svg");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: fortmeier_breathing_plots PATIENT_FOLDER OUT_FOLDER\n";
    return 2;
  }
  try {
    Draw(argv[1], argv[2]);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
